# An airliner, built from edges: a fuselage lofted from a round pole at the nose to one at the tail, wings, tailplanes and a
# fin lofted out of windows in it, so that fairings and wings are one surface, all sewn to one solid.
#
# Narrow on purpose: blunt trailing edges, and the strips of the fuselage where they run together at nose and tail.
units("m")

radius = 1.9
span = 16
edge = 0.015

# --------------------------------------------------------------------------------------------------------- fuselage
low = -55
high = -12
fin = 78


def spot(x, r, z, a):
    return (x, r * cos(radians(a)), z + r * sin(radians(a)))


def bow(x, r, z, a, b):
    return arc(spot(x, r, z, a), spot(x, r, z, (a + b) / 2), spot(x, r, z, b))


# Six arcs: the windows of the right wing, of the fin and of the left wing, and what is between them.
def ring(x, r, z):
    return chain(
        [
            bow(x, r, z, low, high),
            bow(x, r, z, high, fin),
            bow(x, r, z, fin, 180 - fin),
            bow(x, r, z, 180 - fin, 180 - high),
            bow(x, r, z, 180 - high, 180 - low),
            bow(x, r, z, 180 - low, 360 + low),
        ]
    )


nose = loft(
    [(0, 0, -0.5), ring(0.5, 0.75, -0.42), ring(1.8, 1.35, -0.22), ring(4, 1.8, -0.04), ring(7, radius, 0)],
    round=(True, False),
    square=(False, True),
    solid=False,
).name("nose")
cabin = extrude_edges(ring(7, radius, 0), "x", 5, solid=False).name("cabin")
bay = extrude_edges(ring(12, radius, 0), "x", 6, solid=False).without("side1", "side5").name("bay")
aft = extrude_edges(ring(18, radius, 0), "x", 3, solid=False).name("aft")
rear = loft(
    [ring(21, radius, 0), ring(24, 1.62, 0.25), ring(27, 1.1, 0.72)], square=(True, False), solid=False
).name("rear")
stern = loft([ring(27, 1.1, 0.72), ring(30, 0.62, 1.15)], ruled=True, solid=False)
stern = stern.without("side1", "side3", "side5").name("stern")
cone = loft([ring(30, 0.62, 1.15), ring(31, 0.45, 1.28), (31.8, 0, 1.36)], round=(False, True), solid=False).name("cone")


# ------------------------------------------------------------------------------------------------------------ wings
# Half the thickness of a NACA profile of thickness t at a share of its chord, never below the trailing edge's.
def half(t, s):
    return max(edge * s, 5 * t * (0.2969 * sqrt(s) - 0.126 * s - 0.3516 * s**2 + 0.2843 * s**3 - 0.1015 * s**4))


front = 0.03
shares = [front, 0.08, 0.18, 0.35, 0.55, 0.78, 1]


# Four edges in the xz plane: around the leading edge, along the top, down the trailing edge, back below.
def profile(c, t):
    return chain(
        [
            spline([(s * c, 0, half(t, s) * k * c) for s, k in [(front, -1), (0.008, -1), (0, 0), (0.008, 1), (front, 1)]]),
            spline([(s * c, 0, half(t, s) * c) for s in shares]),
            polyline([(c, 0, half(t, 1) * c), (c, 0, -half(t, 1) * c)]),
            spline([(s * c, 0, -half(t, s) * c) for s in [1 - v for v in [0, 0.22, 0.45, 0.65, 0.82, 0.92, 1 - front]]]),
        ]
    )


# The window between two frames of the fuselage, from angle a to b: four edges in the order of the profile's.
def window(f, g, a, b):
    return chain(
        [
            bow(f[0], f[1], f[2], a, b),
            polyline([spot(f[0], f[1], f[2], b), spot(g[0], g[1], g[2], b)]),
            bow(g[0], g[1], g[2], b, a),
            polyline([spot(g[0], g[1], g[2], a), spot(f[0], f[1], f[2], a)]),
        ]
    )


# A fairing from a window to the first profile, the wing through all profiles, and its tip.
def wing(root, profiles):
    return sew(
        [
            loft([root, profiles[0]], square=(False, True), solid=False).name("fairing"),
            loft(profiles, solid=False).name("skin"),
            flat_face(profiles[len(profiles) - 1]).name("tip"),
        ],
        solid=False,
    )


def wing_profiles(side):
    return [
        profile(5.2, 0.16).move((12.5, side * 3.2, -0.95)),
        profile(4.2, 0.14).move((13.9, side * 5.6, -0.78)),
        profile(2.9, 0.12).move((15.9, side * 9.8, -0.45)),
        profile(1.8, 0.13).move((18.6, side * span, 0.1)),
    ]


def tail_profiles(side):
    return [profile(2.6, 0.15).move((27.5, side * 1.6, 0.66)), profile(1.5, 0.14).move((29.5, side * 5.2, 1))]


# Profiles upright: their thickness across.
def upright(c, t):
    return profile(c, t).rotate(90, axis="x")


frames = ((12, radius, 0), (18, radius, 0))
ends = ((27, 1.1, 0.72), (30, 0.62, 1.15))
right = wing(window(frames[0], frames[1], low, high), wing_profiles(1)).name("right")
left = wing(window(frames[0], frames[1], 180 - low, 180 - high), wing_profiles(-1)).name("left")
right_tail = wing(window(ends[0], ends[1], low, high), tail_profiles(1)).name("right_tail")
left_tail = wing(window(ends[0], ends[1], 180 - low, 180 - high), tail_profiles(-1)).name("left_tail")
upper = [upright(2.6, 0.15).move((27.4, 0, 2.3)), upright(1.6, 0.14).move((29.7, 0, 6.4))]
rudder = wing(window(ends[0], ends[1], fin, 180 - fin), upper).name("fin")

part(sew([nose, cabin, bay, aft, rear, stern, cone, right, left, right_tail, left_tail, rudder]).name("aircraft"))
mesh(size="0.5%")
group("wings", faces("aircraft.right.*", "aircraft.left.*"))
