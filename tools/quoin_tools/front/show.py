"""Shows the results of a run, or a block mesh.

    quoin show out                    its numbers, in the terminal
    quoin show out --pictures         pictures, into the same folder
    quoin show out --film             film of a stage in time or of a failure
    quoin show out --html             one page to look into it, in any browser
    quoin show model.h5 [-o mesh.png] picture of a block mesh

`quoin show --pictures -h`, `--film -h`, `--html -h` and
`quoin show model.h5 -h` say which options these take."""

import os


def main(words):
    """Prints the numbers of a run, or draws a block mesh. The options of `quoin show` stand in front/main.py."""
    if not words or words[0] in ("-h", "--help"):
        print(__doc__.strip())
        return 0 if words else 2
    meshes = [word for word in words if word.endswith(".h5") and os.path.basename(word) != "results.h5"]
    if not meshes:
        from quoin_tools.base.results import main as numbers

        return numbers(words)
    from quoin_tools.show.plot_mesh import main as picture

    named = {"-o", "--output", "-h", "--help"} & set(words)
    return picture(words if named else [*words, "-o", os.path.splitext(meshes[0])[0] + ".png"])
