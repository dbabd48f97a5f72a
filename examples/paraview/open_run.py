"""Opens what a run has written for ParaView, and saves pictures: `pvpython open_run.py RUN`.

RUN is the folder of a run. `envelopes.vtm` (parts: dam, cracks) is in every one whose dam keeps envelopes; `snapshots.pvd` (parts: dam,
contacts, wet_face, reservoir, the last two of a tailwater too) with `--set snapshots.interval=0.05`. Names of fields end with their units.
"""

import sys
from pathlib import Path

from paraview import simple as pv

STRESS = "major_principal_stress_max [Pa]"
DISPLACEMENT = "displacement [m]"
# Displacements are shown this many times too large.
FACTOR = 50


def picture(view, path):
    view.ResetCamera()
    pv.SaveScreenshot(str(path), view, ImageResolution=[1600, 1200])
    print(path)


def envelope(run, view):
    """The section, coloured by the largest principal stress of the run."""
    source = pv.XMLMultiBlockDataReader(FileName=[str(run / "envelopes.vtm")])
    dam = pv.ExtractBlock(Input=source, Selectors=["//dam"])
    shown = pv.Show(dam, view)
    pv.ColorBy(shown, ("POINTS", STRESS))
    shown.RescaleTransferFunctionToDataRange(True)
    shown.SetScalarBarVisibility(view, True)
    picture(view, run / "envelope.png")
    pv.Hide(dam, view)


def deformed(run, view):
    """The deformed dam at the last picture of the run, coloured by the major principal stress."""
    source = pv.PVDReader(FileName=str(run / "snapshots.pvd"))
    scene = pv.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.GoToLast()
    warped = pv.WarpByVector(Input=source, Vectors=["POINTS", DISPLACEMENT], ScaleFactor=FACTOR)
    shown = pv.Show(warped, view)
    pv.ColorBy(shown, ("CELLS", "major_principal_stress [Pa]"))
    shown.SetScalarBarVisibility(view, True)
    picture(view, run / "deformed.png")


def water(run, view):
    """The pressure in the water at the last picture of the run."""
    source = pv.PVDReader(FileName=str(run / "snapshots.pvd"))
    scene = pv.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.GoToLast()
    shown = pv.Show(source, view)
    pv.ColorBy(shown, ("POINTS", "hydrodynamic_pressure [Pa]"))
    shown.RescaleTransferFunctionToDataRange(True)
    shown.SetScalarBarVisibility(view, True)
    picture(view, run / "water.png")
    pv.Hide(source, view)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    run = Path(sys.argv[1])
    view = pv.GetActiveViewOrCreate("RenderView")
    shows = [("envelopes.vtm", envelope), ("snapshots.pvd", water), ("snapshots.pvd", deformed)]
    there = [show for name, show in shows if (run / name).is_file()]
    if not there:
        sys.exit(f"{run}: neither envelopes.vtm nor snapshots.pvd is there; give the folder of a run")
    for show in there:
        show(run, view)


main()
