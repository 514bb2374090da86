"""A run in ParaView: open this file there (File > Load State), or start `paraview --script=FOLDER/paraview_state.py`.

Three views of FOLDER/results.xdmf: groups with the state of joints, the least principal stress, the opening of joints; blocks are drawn displaced.
`quoin export FOLDER --paraview` writes a copy of this module there; it needs ParaView's own modules only."""

import math
import os
import xml.etree.ElementTree as ElementTree

FOLDER = ""  # of the run; the copy has it
STATE_COLOURS = {0: (0.45, 0.5, 0.53), 1: (0.76, 0.07, 0.12), 2: (0.56, 0.14, 0.67), 3: (0.9, 0.2, 0.5), 4: (0.0, 0.0, 0.0), 6: (0.3, 0.0, 0.3)}
GROUP_COLOURS = ((0.85, 0.78, 0.66), (0.71, 0.77, 0.81), (0.81, 0.86, 0.71), (0.89, 0.76, 0.76), (0.81, 0.77, 0.88), (0.76, 0.87, 0.84))
PART = 0.06  # of the size of the model: how far the largest displacement is drawn


def meanings(path):
    """Reads the names in a results.xdmf: {"group": {0: name}, "joint": ..., "state": ...}, and [(time, stage or frame)]."""
    domain = ElementTree.parse(path).getroot().find("Domain")  # noqa: S314  a file that the run has written
    names = {}
    for item in domain.findall("Information"):
        kind, number = item.get("Name").split()
        names.setdefault(kind, {})[int(number)] = item.get("Value")
    steps = [(float(grid.find("Time").get("Value")), grid.get("Name")) for grid in domain.find("Grid").findall("Grid")]
    names["state"] |= {3: "open, slipping", 6: "slipping, crushing"}  # sums
    return names, steps


def folder():
    """Where results.xdmf is: beside this file, else where it was written."""
    beside = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else ""
    return beside if os.path.isfile(os.path.join(beside, "results.xdmf")) else FOLDER


def scale_of(largest, size):
    """Returns the scale 1, 2, 5, 10, ... that makes the largest displacement a visible part of the size; 1 where it is larger."""
    if not largest > 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(PART * size / largest))
    return max(1.0, power * max(step for step in (1, 2, 5) if step * power <= PART * size / largest * (1 + 1e-9)))


def named(simple, field, names, colours):
    """Colours of a field whose values are names."""
    table = simple.GetColorTransferFunction(field)
    table.InterpretValuesAsCategories = 1
    table.Annotations = [text for number, name in sorted(names.items()) for text in (str(number), name)]
    table.IndexedColors = [part for number in sorted(names) for part in colours(number)]
    return table


def extracted(simple, reader, name, factor):
    """A grid of the run, displaced."""
    grid = simple.ExtractBlock(registrationName=name, Input=reader, Selectors=[f"//*[starts-with(@label,'{name}')]"])  # VTK numbers them by times
    merged = simple.MergeBlocks(registrationName=f"{name}, whole", Input=grid)
    warp = simple.WarpByVector(registrationName=f"{name} displaced", Input=merged, Vectors=["POINTS", "displacement"], ScaleFactor=factor)
    return merged, warp


def show(simple, view, source, array, association, kind="Surface", width=1.0):
    shown = simple.Show(source, view)
    shown.Representation = kind
    shown.LineWidth = width
    shown.EdgeColor = (0.55, 0.55, 0.55)
    shown.Ambient, shown.Diffuse = 1.0, 0.0  # flat colours, those of the bar
    simple.ColorBy(shown, (association, array) if array else None)
    if array:
        table = simple.GetColorTransferFunction(array)
        table.NanColor = (0.9, 0.9, 0.9)
        bar = simple.GetScalarBar(table, view)
        bar.TitleColor = bar.LabelColor = (0, 0, 0)
        shown.SetScalarBarVisibility(view, True)
    return shown


def new_view(simple, words):
    view = simple.CreateView("RenderView")
    view.InteractionMode = "2D"
    view.UseColorPaletteForBackground = 0
    view.Background = (1, 1, 1)
    view.OrientationAxesVisibility = 0
    title = simple.Show(simple.Text(registrationName=words, Text=words), view)
    title.WindowLocation, title.Color, title.FontSize = "Lower Center", (0, 0, 0), 12
    return view


def main():
    from paraview import simple

    path = os.path.join(folder(), "results.xdmf")
    names, steps = meanings(path)
    simple._DisableFirstRenderCameraReset()
    reader = simple.XDMFReader(registrationName="results", FileNames=[path])
    reader.UpdatePipelineInformation()
    times = simple.GetTimeKeeper().TimestepValues
    simple.GetAnimationScene().AnimationTime = steps[-1][0]
    simple.UpdatePipeline(time=steps[-1][0], proxy=reader)
    whole, _ = extracted(simple, reader, "blocks", 1.0)
    whole.UpdatePipeline(time=steps[-1][0])
    low_x, high_x, low_y, high_y = whole.GetDataInformation().GetBounds()[:4]
    largest = whole.PointData["displacement"].GetRange(-1)[1]
    factor = scale_of(largest, max(high_x - low_x, high_y - low_y))
    _, blocks = extracted(simple, reader, "blocks", factor)
    with open(path, encoding="utf-8") as file:
        has_contacts = '<Grid Name="contacts">' in file.read()
    contacts = extracted(simple, reader, "contacts", factor)[1] if has_contacts else None
    words = f"displacements x {factor:g}; tension is positive, SI units"
    layout = simple.CreateLayout("Run")
    views = [new_view(simple, f"{what}; {words}") for what in ("groups, state of joints", "least principal stress s2 [Pa]", "opening of joints [m]")]
    for view, cell in zip(views, (0, 1, 2)):
        simple.AssignViewToLayout(view=view, layout=layout, hint=cell)
    named(simple, "group", names["group"], lambda number: GROUP_COLOURS[number % len(GROUP_COLOURS)])
    named(simple, "state", names["state"], lambda number: STATE_COLOURS[number])
    show(simple, views[0], blocks, "group", "CELLS", "Surface With Edges")
    show(simple, views[1], blocks, "s2", "CELLS")
    show(simple, views[2], blocks, None, "CELLS").AmbientColor = (0.85, 0.85, 0.82)
    if contacts:
        show(simple, views[0], contacts, "state", "POINTS", "Wireframe", 3.0)
        show(simple, views[2], contacts, "opening", "POINTS", "Wireframe", 4.0)
    named_times = "\n".join(f"{time:g}: {name}" for time, name in steps[:12]) + ("\n..." if len(steps) > 12 else "")
    listed = simple.Show(simple.Text(registrationName="stages", Text=f"time: stage\n{named_times}"), views[0])
    listed.WindowLocation, listed.Color, listed.FontSize = "Upper Left Corner", (0, 0, 0), 11
    for view in views:
        view.CameraPosition = (0.5 * (low_x + high_x), 0.5 * (low_y + high_y), 10 * (high_x - low_x))
        view.CameraFocalPoint = (0.5 * (low_x + high_x), 0.5 * (low_y + high_y), 0)
        view.CameraParallelScale = 0.55 * max(high_y - low_y, high_x - low_x)
        view.ViewTime = steps[-1][0]
    simple.RenderAllViews()
    return factor, views, times


if __name__ in ("__main__", "__vtkconsole__"):
    main()
