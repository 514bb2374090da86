"""What a run has found.

    quoin show out                    its numbers, in the terminal
    quoin show out --pictures         pictures, into the same folder
    quoin show out --film             film of a stage in time or of a failure
    quoin show out --html             one page to look into it, in any browser
    quoin show model.h5 [-o mesh.png] picture of a block mesh

`quoin plots -h`, `quoin animate -h` and `quoin plot_mesh -h` say what else
these take."""

import os


def main(words):
    if not words or words[0] in ("-h", "--help"):
        print(__doc__.strip())
        return 0 if words else 2
    chosen = [word for word in ("--pictures", "--film", "--html") if word in words]
    rest = [word for word in words if word not in chosen]
    if len(chosen) > 1:
        return max(main_of(word, rest) for word in chosen)
    meshes = [word for word in rest if word.endswith(".h5") and os.path.basename(word) != "results.h5"]
    if meshes and not chosen:
        named = {"-o", "--output"} & set(rest)
        return main_of("mesh", rest if named else [*rest, "-o", os.path.splitext(meshes[0])[0] + ".png"])
    return main_of(*chosen or ["numbers"], rest)


def main_of(what, words):
    if what == "mesh":
        from quoin_tools.show.plot_mesh import main as chosen
    elif what == "--pictures":
        from quoin_tools.show.plots import main as chosen
    elif what == "--film":
        from quoin_tools.show.animate import main as chosen
    elif what == "--html":
        from quoin_tools.show.viewer import main as chosen
    else:
        from quoin_tools.base.results import main as chosen
    return chosen(words)
