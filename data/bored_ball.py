# A ball from a STEP file, bored through and cut flat by R-functions: exact edges between CAD surfaces and implicit ones.
units("mm")
ball = step("step/sphere.step").name("ball")
bore = cylinder(0.8, axis="z").name("bore")
foot = half_space(normal=(0, 0, 1), at=(0, 0, -1.5)).name("foot")
part(ball - bore - foot)
mesh(size=0.25)
