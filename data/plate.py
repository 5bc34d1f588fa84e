# A plate of the plane: a rectangle with round holes, a slot and a notch. `rvachev mesh data/plate.py -o plate.svg -o plate.msh`
width = 120
height = 80
units("mm")

plate = rectangle(size=(width, height)).name("plate")
bolts = union([circle(5, at=(x, y)) for x in (-50, 50) for y in (-30, 30)]).name("bolts")
window = circle(22).name("window")
notch = polygon([(-10, 50), (10, 50), (0, 25)]).name("notch")
ear = circle(18, at=(60, 0)).name("ear")

part(region((plate | ear) - bolts - window - notch - circle(9, at=(60, 0)).name("pin")))
mesh(size="2.5%")

group("clamped", faces("bolts"))
group("loaded", faces("pin"))
