# A bolt with a thread: one helicoidal inequality instead of a swept profile.

diameter = 1.0
pitch = 0.25
length = 1.6
depth = 0.12
head = 0.9     # distance between opposite flats

units("mm")

r = hypot(x, y)
# the height above the helix through this point, in turns; its cosine repeats along the thread
turn = z / pitch - atan2(y, x) / (2 * pi)
thread = solid(r <= diameter / 2 - depth / 2 + depth / 2 * cos(2 * pi * turn)).name("thread")
shank = thread & box(lo=(-1, -1, 0), hi=(1, 1, length)).name("shank")

flats = [half_space((cos(a * pi / 3), sin(a * pi / 3), 0), at=(head / 2 * cos(a * pi / 3), head / 2 * sin(a * pi / 3), 0))
         .name(f"flat_{a}") for a in range(6)]
hexagon = intersection(flats) & box(lo=(-1, -1, -0.45), hi=(1, 1, 0)).name("head")

part(shank | hexagon)

group("flats", faces("flat_*"))
