"""Texts of part files that are hard to mesh, for `run.py` beside this.

`catalog()` gives the parts in order. Each is the text of a part file as docs/parts.md describes it, with what it is, the size it
asks for where that is not the common one, and by how much its limit of CPU seconds is longer than the common one.
"""
from dataclasses import dataclass

CATALOG = []


@dataclass
class Part:
    name: str
    what: str
    text: str
    size: str | None = None
    patience: int = 1


def part(what, size=None, patience=1):
    """Takes the function's name and the text it returns into the catalog."""

    def keep(make):
        CATALOG.append(Part(make.__name__, what, make().strip() + "\n", size, patience))
        return make

    return keep


def catalog():
    return CATALOG


def joined(operation, terms):
    """R-functions written out: `f + g - sqrt(f**2 + g**2)` for `&`, with plus for `|`, one line for each step."""
    sign = {"&": "-", "|": "+"}[operation]
    lines = [f"w0 = {terms[0]}"]
    for i, term in enumerate(terms[1:], 1):
        lines += [f"t{i} = {term}", f"w{i} = w{i - 1} + t{i} {sign} sqrt(w{i - 1}**2 + t{i}**2)"]
    return "\n".join(lines)


@part("cube with two holes, one formula of R-conjunctions")
def cube_one_formula():
    terms = ["1 - x**2", "1 - y**2", "1 - z**2", "y**2 + z**2 - 0.16", "x**2 + y**2 - 0.16"]
    return f"{joined('&', terms)}\npart(solid(w4).name('all'))"


@part("the same cube, turned, holes of two radii")
def cube_one_formula_turned():
    u, v, w = "(0.8*x + 0.6*y)", "(0.48*x - 0.64*y + 0.6*z)", "(0.36*x - 0.48*y - 0.8*z)"
    terms = [f"1 - {u}**2", f"1 - {v}**2", f"1 - {w}**2", f"{v}**2 + {w}**2 - 0.16", f"{u}**2 + {v}**2 - 0.25"]
    return f"{joined('&', terms)}\npart(solid(w4).name('all'))"


@part("diamond sheet, a cylinder, a sum of two exponentials", size="6%")
def diamond_exponentials():
    return """
sheet = (diamond(1.3, 0.16) & sphere(1.25)).name("sheet")
rod = cylinder(0.22, axis=(0.3, 0.2, 1), height=2.9).name("rod")
one, other = (x - 0.6)**2 + y**2 + z**2, (x + 0.3)**2 + (y - 0.5)**2 + z**2
lumps = solid(exp(-one/0.25) + exp(-other/0.25) >= 0.45).name("lumps")
part((sheet | rod) - lumps)
"""


THREAD = """
units("mm")
pitch = 1.5
# the distance along the axis from the middle of the nearest crest
def off_crest(z, angle):
    return abs(mod(z - pitch*angle/(2*pi), pitch) - pitch/2)

# ISO 68-1: flanks of 60 degrees, crest pitch/8 wide, root pitch/4 wide
def thread_radius(major, u):
    return min(major, max(major - 0.625*pitch*sqrt(3)/2, major - (u - pitch/16)*sqrt(3)))

def hexagon(across, height):
    return intersection([half_space((cos(k*pi/3), sin(k*pi/3), 0), at=(across/2*cos(k*pi/3), across/2*sin(k*pi/3), 0))
                         for k in range(6)]) & box(lo=(-across, -across, 0), hi=(across, across, height))
r = hypot(x, y)
u = off_crest(z, atan2(y, x))
"""


@part("M10 bolt, ISO 68-1 thread by formula")
def bolt_m10():
    return THREAD + """
thread = solid(r <= thread_radius(5, u)).name("thread") & cone(4, 24, 20, at=(0, 0, -14)).name("point")
shank = cylinder(5, height=12, at=(0, 0, -6)).name("shank")
head = (hexagon(16, 6.4) & cone(17.4, 0, 17.4/1.7, at=(0, 0, 5.1)).name("chamfer")).name("head")
part((thread & box(lo=(-6, -6, -24), hi=(6, 6, -11)).name("end")) | shank | head)
group("thread", faces("thread*"))
"""


@part("M10 nut, the thread with 0.1 of play")
def nut_m10():
    return THREAD + """
bore = solid(r <= thread_radius(5.1, u)).name("thread")
rims = cone(5.9, 0, 5.9, at=(0, 0, 2.95)).name("lower") | cone(0, 5.9, 5.9, at=(0, 0, 5.45)).name("upper")
part(hexagon(16, 8.4).name("body") - bore - rims)
"""


@part("foam: a block less 40 balls that overlap")
def foam():
    return """
def at(i, k):
    return (0.31 + (i + 1)*(0.7548776662, 0.5698402910, 0.4301597090, 0.6180339887)[k]) % 1
bubbles = [sphere(0.24 + 0.16*at(i, 3), at=(2*at(i, 0) - 1, 2*at(i, 1) - 1, 2*at(i, 2) - 1)).name(f"bubble{i}") for i in range(40)]
part(box(size=(2, 2, 2)).name("block") - union(bubbles))
"""


@part("NACA 2415 wing, taper and twist")
def wing_twisted():
    return """
units("m")
t = y/5
chord = 1.2*(1 - 0.6*t)
twist = (2 - 7*t)*pi/180
X = (cos(twist)*(x - 0.1*y) - sin(twist)*z)/chord
Z = (sin(twist)*(x - 0.1*y) + cos(twist)*z)/chord
bend = 0.02/0.16*(0.8*X - X**2) if X < 0.4 else 0.02/0.36*(0.2 + 0.8*X - X**2)
half = 0.75*(0.2969*sqrt(X) - 0.126*X - 0.3516*X**2 + 0.2843*X**3 - 0.1036*X**4)
skin = solid(abs(Z - bend) <= half).name("skin") & solid(X <= 0.995).name("trailing")
part(skin & box(lo=(-1, 0, -1), hi=(3, 5, 1)).name("cut"))
"""


@part("impeller: nine spiral blades by mod, on a hub with a keyway")
def impeller():
    return """
units("mm")
pace = 2*pi/9
r = hypot(x, y)
swept = atan2(y, x) - 1.3*log(max(r, 2)/10)
blade = solid(abs(mod(swept, pace) - pace/2)*r*0.6 <= 0.9).name("blade")
room = revolve([(9, 1), (36, 1), (36, 7), (9, 18)]).name("room")
hub = revolve([(0, 0), (36, 0), (36, 2), (18, 4), (11, 9), (9, 19), (0, 19)]).name("hub")
part((blade & room) | (hub - cylinder(4).name("bore") - box(lo=(-1, 0, -1), hi=(1, 5.2, 30)).name("key")))
"""


@part("impeller with blades by atan2(sin, cos)")
def impeller_closed():
    return """
units("mm")
r = hypot(x, y)
swept = 7*(atan2(y, x) - 0.9*log(max(r, 2)/10))
blade = solid(abs(atan2(sin(swept), cos(swept)))*r/7*0.74 <= 0.8).name("blade")
room = (cylinder(30, height=11, at=(0, 0, 6.5)) - cylinder(12)).name("room")
plates = cylinder(30, height=2, at=(0, 0, 1)).name("back") | (cylinder(30, height=2, at=(0, 0, 12)) - cylinder(13)).name("shroud")
part((blade & room) | plates | (cylinder(8, height=16, at=(0, 0, 8)) - cylinder(3)).name("hub"))
"""


@part("propeller: three helicoidal blades with oval outlines")
def propeller():
    return """
r = hypot(x, y)
thick = (0.09 - 0.05*r)*sqrt(r**2 + 0.25)
def along(k):
    return cos(2*pi*k/3)*x + sin(2*pi*k/3)*y
def beside(k):
    return cos(2*pi*k/3)*y - sin(2*pi*k/3)*x
def outline(a, b, k):
    return solid(((a - 0.75)/0.62)**2 + (hypot(b, z)/0.3)**2 <= 1).name(f"outline{k}")
def sheet(a, b, k):
    return solid(abs(z - 0.5*atan2(b, a))*r <= thick).name(f"blade{k}") & solid(a >= 0).name(f"root{k}")
blades = union([sheet(along(k), beside(k), k) & outline(along(k), beside(k), k) for k in range(3)])
hub = (cylinder(0.25, height=0.7) | sphere(0.25, at=(0, 0, 0.35))).name("hub")
part((blades | hub) - cylinder(0.1).name("bore"))
"""


@part("bracket filled with a gyroid sheet, pads and bolt holes")
def gyroid_bracket():
    return """
units("mm")
skin = box(lo=(0, 0, 0), hi=(50, 30, 10)).name("foot") | box(lo=(0, 0, 0), hi=(10, 30, 40)).name("wall")
room = box(lo=(2, -1, 2), hi=(48, 28, 8)).name("low") | box(lo=(2, -1, 2), hi=(8, 28, 38)).name("high")
pads = union([cylinder(5, at=(a, 14, 5), height=10).name(f"pad{a}") for a in (20, 40)])
holes = union([cylinder(2.5, at=(a, 14, 5)).name(f"hole{a}") for a in (20, 40)])
filled = (skin - room) | (room & skin & gyroid(9, 1.6).name("sheet"))
part((filled | pads) - holes)
"""


GEAR = """
units("mm")
module, teeth, turn = {module}, {teeth}, {turn}
pitch_radius = module*teeth/2
base = pitch_radius*cos(radians(20))
r = hypot(x, y)
# half the angle a tooth has at radius r, by its involute
grown = sqrt(max((r/base)**2 - 1, 0))
half = pi/2/teeth + tan(radians(20)) - radians(20) - (grown - atan(grown))
pace = 2*pi/teeth
flank = solid(abs(mod(atan2(y, x) + turn*z, pace) - pace/2) <= half).name("flank")
teeth_of = flank & cylinder(pitch_radius + module, height={width}).name("tip")
body = cylinder(pitch_radius - 1.25*module, height={width}).name("root")
"""


@part("spur gear, 24 involute teeth")
def gear_spur():
    return GEAR.format(module=2, teeth=24, turn=0, width=12) + """
windows = union([cylinder(4, at=(12*cos(k*pi/3), 12*sin(k*pi/3), 0)).name(f"window{k}") for k in range(6)])
part((teeth_of | body) - windows - cylinder(5).name("bore"))
"""


@part("helical gear, 17 involute teeth, with a keyway")
def gear_helical():
    return GEAR.format(module=3, teeth=17, turn=0.018, width=18) + """
part((teeth_of | body) - cylinder(8).name("bore") - box(lo=(-2.5, 0, -10), hi=(2.5, 10.5, 10)).name("key"))
"""


@part("lattice of struts with balls at the nodes")
def lattice_balls():
    return """
nodes = [(i, j, k) for i in range(3) for j in range(3) for k in range(3)]
middles = [(i + 0.5, j + 0.5, k + 0.5) for i in range(2) for j in range(2) for k in range(2)]
ways = [(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)]
struts = [cylinder(0.08, axis=w, at=m, height=sqrt(3)).name(f"strut{i}_{j}")
          for i, m in enumerate(middles) for j, w in enumerate(ways)]
balls = [sphere(0.16, at=n).name(f"ball{i}") for i, n in enumerate(nodes + middles)]
part(union(struts + balls) | box(lo=(-0.3, -0.3, -0.25), hi=(2.3, 2.3, -0.05)).name("floor"))
"""


@part("300 boxes on a grid, planes coincide")
def boxes_on_grid():
    return """
def at(i, k):
    return (0.2 + (i + 1)*(0.8191725134, 0.6710436068, 0.5497004779, 0.4502995221, 0.3689827, 0.3021)[k]) % 1
def low(i):
    return [floor(11*at(i, k)) for k in range(3)]
def high(i):
    return [floor(11*at(i, k)) + 1 + floor(3*at(i, k + 3)) for k in range(3)]
part(union([box(lo=low(i), hi=high(i)).name(f"box{i}") for i in range(300)]))
"""


@part("heat sink: 11 tapered fins, cut across, on a plate with holes")
def heat_sink():
    return """
units("mm")
profile = [(-0.9, 0), (0.9, 0), (0.5, 22), (-0.5, 22)]
fins = [extrude(profile, 60).rotate(90, axis="x").move((6*k - 30, 0, 3)).name(f"fin{k}") for k in range(11)]
plate = box(lo=(-34, -32, 0), hi=(34, 32, 4)).name("plate")
slots = union([box(lo=(-40, s - 1, 9), hi=(40, s + 1, 40)).name(f"slot{s}") for s in (-15, 0, 15)])
holes = union([cylinder(1.6, at=(a, b, 0)).name(f"hole{a}{b}") for a in (-30, 30) for b in (-31, 31)])
part((plate | union(fins)) - slots - holes)
"""


@part("pump housing: a scroll with blended ports and flanges")
def pump_housing():
    return """
units("mm")
drum = cylinder(30, height=30).name("drum")
inlet = cylinder(13, axis="z", at=(0, 0, 25), height=40).name("inlet")
outlet = cylinder(11, axis="x", at=(35, 22, 0), height=70).name("outlet")
foot = box(lo=(-35, -42, -15), hi=(35, -34, 15)).name("foot")
rib = box(lo=(-4, -40, -12), hi=(4, -20, 12)).name("rib")
shell = blend(blend(blend(drum, inlet, 4).name("neck"), outlet, 4).name("throat"), rib | foot, 3).name("sole")
rings = cylinder(20, at=(0, 0, 43), height=5).name("flange") | cylinder(17, axis="x", at=(68, 22, 0), height=5).name("ring")
ways = cylinder(9, at=(0, 0, 30), height=60).name("eye") | cylinder(7, axis="x", at=(45, 22, 0), height=80).name("way")
hollow = cylinder(25, height=22).name("chamber") | ways
bolts = union([cylinder(1.8, at=(16.5*cos(k*pi/2), 16.5*sin(k*pi/2), 43), height=20).name(f"bolt{k}") for k in range(4)])
part((shell | rings) - hollow - bolts)
"""


@part("plate with 35 countersunk holes")
def countersunk_plate():
    return """
units("mm")
holes = [cylinder(1.7, at=(12*i, 12*j, 0)).name(f"hole{i}_{j}") for i in range(7) for j in range(5)]
sinks = [cone(1.7, 3.7, 2, at=(12*i, 12*j, 4)).name(f"sink{i}_{j}") for i in range(7) for j in range(5)]
plate = box(lo=(-8, -8, 0), hi=(80, 56, 5)).name("plate")
part(plate - union(holes + sinks))
"""


@part("two solids that share a plane under two names")
def shared_plane():
    return """
base = box(lo=(0, 0, 0), hi=(3, 2, 1)).name("base")
part(base | (cylinder(0.8, at=(2.2, 1, 0.5), height=1) | box(lo=(2.5, 0.5, 0), hi=(4.5, 1.3, 1))).name("arm"))
"""


@part("two solids that share a cylinder under two names")
def shared_cylinder():
    return """
right = cylinder(1, at=(0, 0, 1.2), height=2) & half_space((1, 0.4, 0.3), at=(0.2, 0, 1))
part(cylinder(1, height=2).name("left") | right.name("right"))
"""


@part("one cylinder under two names by a slanting cut of a formula")
def shared_cylinder_slant():
    return """
tube = x**2 + y**2 <= 1
lower = (solid(tube) & solid(z <= 0.4*x + 0.2*sin(3*y))).name("lower")
upper = (solid(tube) & solid(z >= 0.4*x + 0.2*sin(3*y))).name("upper")
part((lower | upper) & box(lo=(-2, -2, -1), hi=(2, 2, 1)).name("caps"))
"""


@part("tube with 120 radial holes, rows turned by half a step")
def perforated_tube():
    return """
def hole(i, j):
    return cylinder(0.14, axis="x", at=(0, 0, 0.45*j), height=3).rotate(30*i + 15*j, axis="z").name(f"hole{i}_{j}")
part((cylinder(1, height=5) - cylinder(0.9)).name("tube") - union([hole(i, j) for i in range(6) for j in range(-5, 5)]))
"""


@part("spring with ground ends, one formula of a helix")
def spring():
    return """
units("mm")
pitch = 4
off = mod(z - pitch*atan2(y, x)/(2*pi) + pitch/2, pitch) - pitch/2
part(solid(hypot(hypot(x, y) - 8, off) <= 1.1).name("wire") & box(lo=(-10, -10, -11), hi=(10, 10, 11)).name("ground"))
"""


@part("the same spring, its helix by a wave")
def spring_by_wave():
    return """
units("mm")
pitch = 4
off = abs(mod(z - pitch*atan2(y, x)/(2*pi), pitch) - pitch/2)
part(solid(hypot(hypot(x, y) - 8, off) <= 1.1).name("wire") & box(lo=(-10, -10, -11), hi=(10, 10, 11)).name("ground"))
"""


@part("a tube around a helix whose section is a circle in the plane of x and y: a ribbon with rims of a radius of 0.04")
def coil_flat():
    return """
units("mm")
t = 2*pi*z/15
tube = solid(hypot(x - 21*cos(t), y - 21*sin(t)) <= 3).name("tube")
part(tube & box(lo=(-30, -30, 8), hi=(30, 30, 45)).name("ends"))
"""


@part("two threads through a wall")
def wall_threads():
    return """
units("mm")
pitch = 2
def bore(a, b, c, r):
    return solid(hypot(a, b) <= r + 0.5*(1 - 4/pitch*abs(mod(c - pitch*atan2(b, a)/(2*pi), pitch) - pitch/2)))
wall = box(lo=(-20, -12, 0), hi=(20, 12, 9)).name("wall")
part(wall - (bore(x + 10, y, z, 5).name("right") | bore(x - 8, 1 - y, z, 7).name("left")))
"""


@part("rook: a body of revolution, profile by formula, with battlements")
def rook():
    return """
r = hypot(x, y)
body = solid(r <= 0.45 + 0.25*exp(-4*z) + 0.04*sin(9*z)).name("body") & box(lo=(-2, -2, 0), hi=(2, 2, 2)).name("cut")
top = revolve([(0, 1.8), (0.42, 1.8), (0.62, 2.0), (0.62, 2.5), (0, 2.5)]).name("top")
collar = torus(0.5, 0.1, at=(0, 0, 0.35)).name("collar") | top
cup = cylinder(0.44, at=(0, 0, 2.5), height=0.5).name("cup")
gaps = solid(abs(mod(atan2(y, x), pi/3) - pi/6) <= 0.16).name("gap") & box(lo=(-1, -1, 2.32), hi=(1, 1, 3)).name("floor")
part((body | collar) - cup - gaps)
"""


@part("porous block, stretched schwarz_p by formula")
def porous_block():
    return """
pores = solid(cos(2*pi*x) + cos(2*pi*y/1.5) + cos(2*pi*z/0.8) <= 0.35).name("pores")
part(pores & box(lo=(0.1, 0.1, 0.1), hi=(2.9, 2.4, 1.7)).name("block"))
"""


@part("porous block by schwarz_p's sheet, less a bore")
def porous_sheet():
    return """
part((schwarz_p(1, 0.2).name("sheet") & box(size=(3, 2.4, 2)).name("block")) - cylinder(0.6, axis=(0.1, 0.2, 1)).name("bore"))
"""


@part("knurled knob: two crossing helical waves")
def knurled_knob():
    return """
units("mm")
r = hypot(x, y)
pace = 2*pi/36
def wave(a):
    return abs(mod(a, pace) - pace/2)
cut = max(wave(atan2(y, x) + z/14), wave(atan2(y, x) - z/14))
grip = solid(r <= 12.6 - 8*cut).name("grip") & box(lo=(-20, -20, 0), hi=(20, 20, 12)).name("ends")
part((grip & cone(25, 0, 25, at=(0, 0, 11.5)).name("chamfer")) - cylinder(3).name("bore"))
"""


@part("grid of hexagonal holes by mod, in a curved sheet")
def hexagonal_grille():
    return """
def hexagon(a, b):
    return max(abs(a), abs(a)/2 + abs(b)*sqrt(3)/2)
s = sqrt(3)
first = hexagon(mod(x + 0.5, 1) - 0.5, mod(y + s/2, s) - s/2)
second = hexagon(mod(x, 1) - 0.5, mod(y, s) - s/2)
sheet = solid(abs(z - 0.15*(x**2 - y**2/2)) <= 0.12).name("sheet") & box(size=(5.2, 4.4, 4)).name("frame")
part(sheet - solid(min(first, second) <= 0.4).name("holes"))
"""


@part("snail cam, its radius by atan2, with a wall where that jumps")
def snail_cam():
    return """
cam = solid(hypot(x, y) <= 1 + atan2(y, x)/(4*pi)).name("cam") & box(size=(4, 4, 0.5)).name("ends")
part(cam - cylinder(0.3).name("bore"))
"""


@part("spiral ramp by atan2 in a drum, with a step where that jumps")
def spiral_ramp():
    return """
part(solid(z <= 0.3*atan2(y, x)).name("ramp") & cylinder(1, height=3).name("drum"))
"""


@part("treads around an axis, by floor of an angle")
def winding_stairs():
    return """
step = floor(atan2(y, x)*6/pi)*0.25
treads = solid(z <= step + 2).name("top") & solid(z >= step + 1.7).name("bottom") & cylinder(3).name("rim") - cylinder(0.8)
part(treads | cylinder(0.9, height=5).name("post"))
"""


@part("a plate with 81 round holes, by mod of both coordinates")
def perforated_plate():
    return """
u = mod(x + 0.25, 0.5) - 0.25
v = mod(y + 0.25, 0.5) - 0.25
part(box(size=(4, 4, 0.1)).name("plate") - solid(hypot(u, v) <= 0.15).name("holes"))
"""


# Distances to a block and to a rod as they are commonly written.
DISTANCES = """
def block(u, v, w, a, b, c):
    p, q, r = abs(u) - a, abs(v) - b, abs(w) - c
    return hypot(max(p, 0), max(q, 0), max(r, 0)) + min(max(p, q, r), 0)
def rod(u, v, w, a, h):
    p, q = hypot(u, v) - a, abs(w) - h
    return min(max(p, q), 0) + hypot(max(p, 0), max(q, 0))
"""


@part("balls and a rod joined by polynomial minima, as distance fields are")
def smooth_minima():
    return """
def smin(a, b, k):
    return min(a, b) - max(k - abs(a - b), 0)**2 / (4*k)
def ball(a, b, c, r):
    return sqrt((x - a)**2 + (y - b)**2 + (z - c)**2) - r
balls = smin(smin(ball(0, 0, 0, 1), ball(1.2, 0, 0.3, 0.7), 0.4), ball(-1, 0.5, 0.2, 0.6), 0.3)
rod = max(hypot(x - 0.2, y) - 0.3, abs(z) - 1.6)
part(solid(-smin(balls, rod, 0.3)))
"""


@part("a figure of a ball, a rounded block and a rod, joined by smooth minima, as distance fields are")
def smooth_figure():
    return DISTANCES + """
def smin(a, b, k):
    h = clamp(0.5 + 0.5*(b - a)/k, 0, 1)
    return b*(1 - h) + a*h - k*h*(1 - h)
head = hypot(x, y, z - 1.2) - 0.5
body = block(x, y, z, 0.5, 0.3, 0.7) - 0.1
arms = rod(z - 0.4, y, x, 0.15, 1.2)
figure = smin(smin(head, body, 0.2), arms, 0.15)
part(solid(figure <= 0))
"""


@part("a block with six pockets rounded off, by smooth maxima of distances")
def smooth_pockets():
    return DISTANCES + """
def smax(a, b, k):
    return max(a, b) + max(k - abs(a - b), 0)**2/(4*k)
d = rod(x, y, z, 1, 0.2)
for i in range(6):
    a = 2*pi*i/6
    d = smax(d, -rod(x - 0.65*cos(a), y - 0.65*sin(a), z, 0.15, 1), 0.04)
part(solid(d <= 0))
"""


@part("a bored block, a rod and a rounded block, by distances as they are commonly written")
def distance_block():
    return DISTANCES + """
bored = max(block(x, y, z, 1, 0.8, 0.5), -rod(x, y, z, 0.4, 2))
part(solid(-min(bored, rod(x - 1, z, y, 0.3, 0.5), block(x + 1.5, y, z, 0.7, 0.6, 0.3) - 0.1)))
"""


@part("a block with waves on it, by distances as they are commonly written")
def distance_waves():
    return DISTANCES + """
d = block(x, y, z, 0.8, 0.7, 0.5)
part(solid(d - 0.05*sin(10*x)*sin(10*y)*sin(10*z) <= 0))
"""


@part("between a block and a ball, by a mixture of their distances")
def distance_mixture():
    return DISTANCES + """
d = block(x, y, z, 0.8, 0.7, 0.5)
part(solid(0.6*d + 0.4*(hypot(x - 0.5, y - 0.4, z - 0.45) - 0.6) <= 0))
"""


@part("rings and plates repeated by round and clamp, rounded off")
def repeated_by_clamp():
    return """
def near(v, step, last):
    return v - step*clamp(round(v/step), -last, last)
def plate(u, v, w):
    p, q, r = abs(u) - 0.3, abs(v) - 0.25, abs(w) - 0.2
    return hypot(max(p, 0), max(q, 0), max(r, 0)) + min(max(p, q, r), 0)
plates = plate(near(x, 0.8, 2), near(y, 0.8, 1), z) - 0.05
rings = hypot(hypot(near(x, 0.8, 2), near(y, 0.8, 1)) - 0.3, z - 0.3) - 0.08
part(solid(plates <= 0).name("plates") | solid(rings <= 0).name("rings"))
"""


@part("a swept wing that tapers to both sides")
def wing_tapered():
    return """
c = 1 - 0.25*abs(z)
X = (x + 0.2*abs(z))/c
yt = 0.6*(0.2969*sqrt(X) - 0.126*X - 0.3516*X**2 + 0.2843*X**3 - 0.1036*X**4)
part(solid(yt*c - abs(y)).name("skin") & box(lo=(-1, -1, -2), hi=(1.5, 1, 2)).name("ends"))
"""


@part("six metaballs with a flat, one formula")
def metaballs():
    terms = " + ".join(f"1/((x - {a})**2 + (y - {b})**2 + (z - {c})**2 + 0.01)"
                       for a, b, c in [(0, 0, 0), (1, 0.3, 0), (0.2, 1, 0.4), (-0.7, 0.2, 0.6), (0.1, -0.9, 0.2), (0.3, 0.1, 1.1)])
    return f"part(solid({terms} >= 9).name('lumps') & solid(z >= -0.1 + 0.05*x).name('flat'))"


@part("thin shell of 0.3 % of its size, with a window")
def thin_shell():
    return """
shell = ellipsoid((1, 0.8, 0.6)).name("outer") - ellipsoid((0.995, 0.795, 0.595)).name("inner")
part(shell - box(lo=(0.2, -0.3, 0), hi=(0.7, 0.3, 1)).name("window"))
"""


@part("balls and cylinders that touch planes")
def tangent_solids():
    return """
slab = box(lo=(-3, -2, -0.5), hi=(3, 2, 0)).name("slab")
part(slab | sphere(0.7, at=(-1.8, 0, 0.7)).name("ball") | cylinder(0.5, axis="y", at=(0.3, 0, 0.5), height=2).name("roll")
    | cylinder(0.6, at=(2.4, 0, 0.5), height=2).name("post"))
"""


@part("Moebius strip with square edges, one formula")
def moebius():
    return """
r = hypot(x, y)
a = atan2(y, x)/2
p = cos(a)*(r - 1) + sin(a)*z
q = cos(a)*z - sin(a)*(r - 1)
part(solid(min(0.35 - abs(p), 0.06 - abs(q))).name("strip"), domain=((-2, -2, -1), (2, 2, 1)))
"""


@part("worm whose wave is the smaller of mod and its rest")
def worm_wave():
    return """
w = mod(z - atan2(y, x)/pi, 2)
thread = solid(hypot(x, y) <= 1.6 + 1.2*min(w, 2 - w)).name("thread")
part(thread & cylinder(2.5, height=9).name("crest") | cylinder(1.0, height=14).name("shaft"))
"""


@part("block and rod, rounded off by a cubic smooth minimum")
def smooth_cubic():
    return """
def block(u, v, w, a, b, c):
    p, q, r = abs(u) - a, abs(v) - b, abs(w) - c
    return hypot(max(p, 0), max(q, 0), max(r, 0)) + min(max(p, q, r), 0)
def rod(u, v, w, r, h):
    p, q = hypot(u, v) - r, abs(w) - h
    return min(max(p, q), 0) + hypot(max(p, 0), max(q, 0))
def smin(a, b, k):
    h = max(k - abs(a - b), 0)/k
    return min(a, b) - h*h*h*k/6
part(solid(smin(block(x, y, z, 1, 1, 0.4), rod(x, y, z - 0.6, 0.4, 0.8), 0.3) <= 0))
"""


@part("solid inside a Klein bottle, which crosses itself")
def klein_bottle():
    return """
a = x**2 + y**2 + z**2
part(solid((a + 2*y - 1)*((a - 2*y - 1)**2 - 8*z**2) + 16*x*z*(a - 2*y - 1) <= 0).name("bottle") & box(size=(7, 7, 7)))
"""


SCATTERED = """
counts = {counts}
def at(i, k):
    return (0.4 + (i + 1)*(0.8191725134, 0.6710436068, 0.5497004779, 0.4502995221)[k]) % 1
def place(i):
    return (i % counts[0] + 0.6*at(i, 0), i // counts[0] % counts[1] + 0.6*at(i, 1), i // (counts[0]*counts[1]) + 0.6*at(i, 2))
def ball(i):
    return sphere(0.3 + 0.25*at(i, 3), at=place(i)).name(f"ball{{i}}")
def brick(i):
    return box(size=(0.4 + 0.6*at(i, 3), 0.5 + 0.4*at(i, 0), 0.9 - 0.4*at(i, 1)), at=place(i)).name(f"box{{i}}")
part(union([ball(i) if i % 2 else brick(i) for i in range(counts[0]*counts[1]*counts[2])]))
"""


@part("1000 balls and boxes on a jittered grid")
def solids_1000():
    return SCATTERED.format(counts=(10, 10, 10))


@part("10 000 balls and boxes on a jittered grid", size="1%", patience=5)
def solids_10000():
    return SCATTERED.format(counts=(20, 20, 25))
