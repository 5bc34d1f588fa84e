# A bracket: held by its wall, loaded by a pin through its arm. A part file; the programs beside it compute with it.
units("mm")
wall = box(lo=(0, -15, 0), hi=(6, 15, 40)).name("wall")
arm = box(lo=(3, -12, 14), hi=(40, 12, 22)).name("arm")
pin = cylinder(5, axis="z", at=(30, 0, 18)).name("pin")
part((wall | arm) - pin)
group("clamped", "wall.xmin")
group("loaded", "pin")
