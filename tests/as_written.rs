//! Solids as users write them, in forms that fall into smooth leaves only by what the program knows of formulas: known volumes, at the
//! first attempt.

use std::f64::consts::PI;

use approx::{abs_diff_eq, relative_eq};
use rvachev::Run;
use rvachev::implicit::part::parse;
use rvachev::pipeline::{MeshOptions, Meshed, mesh_part};
use rvachev::quality::Check;

fn made(text: &str) -> Meshed {
    mesh_part(&parse(text, &[]).unwrap(), &MeshOptions::default(), &Run::new()).unwrap()
}

/// What was measured of a mesh that came out at once, its edges and corners exact.
fn at_once(text: &str) -> Check {
    let made = made(text);
    assert_eq!((made.report.method, &made.report.shortfalls), ("leaf", &Vec::new()), "{text}");
    assert_eq!(made.report.attempts.len(), 1, "{text}");
    // Nothing is said of creases where the cases of a formula agree.
    assert_eq!(made.report.warnings, Vec::<String>::new(), "{text}");
    let c = made.report.check.unwrap();
    assert!(c.certificate.is_sound(), "{text}: {:?}", c.certificate);
    let f = c.features.unwrap();
    assert!(f.recall >= 0.99 && f.precision >= 0.97 && f.corners_found == f.corners_true, "{text}: {f:?}");
    c
}

fn near(volume: Option<f64>, truth: f64, share: f64, text: &str) {
    let volume = volume.unwrap();
    assert!(abs_diff_eq!(volume, truth, epsilon = share * truth), "{text}: {volume} {truth}");
}

/// The volume of two balls, the lens of both counted once.
fn two_balls(a: f64, b: f64, d: f64) -> f64 {
    let ball = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
    let lens = PI * (a + b - d).powi(2) * (d * d + 2.0 * d * (a + b) - 3.0 * (a - b).powi(2)) / (12.0 * d);
    ball(a) + ball(b) - lens
}

/// Balls that overlap by less and less: their common circle bends far more than either.
#[test]
fn balls_that_hardly_overlap_meet_in_a_circle() {
    let (a, b) = (1.0, 0.7123);
    for overlap in [0.1, 0.03, 0.0123] {
        let d = a + b - overlap;
        let text = format!("part(sphere({a}).name('a') | sphere({b}, at=(0, 0, {d})).name('b'))\nmesh(size=0.43)\n");
        let c = at_once(&text);
        assert_eq!((c.euler, c.components), (2, 1), "{text}");
        near(c.volume, two_balls(a, b, d), 4e-2, &text);
    }
}

/// Three spiral arms of one width, an arc: between two of them the angle jumps.
#[test]
fn the_width_of_a_spiral_arm_is_an_arc() {
    let text = "r = hypot(x, y)\n\
                t = 3 * (atan2(y, x) - log(r / 10) / 0.6)\n\
                w = atan2(sin(t), cos(t)) / 3 * r\n\
                arm = solid(abs(w) <= 1.5).name('arm')\n\
                ring = cylinder(30, height=4).name('rim') - cylinder(12).name('eye')\n\
                part(arm & ring)\nmesh(size=1.5)\n";
    let c = at_once(text);
    assert_eq!((c.euler, c.components), (6, 3));
    // At each radius the three arms take arcs 3 long.
    near(c.volume, 3.0 * 3.0 * (30.0 - 12.0) * 4.0, 2e-3, text);
}

/// A worm whose profile is written with `mod`: the volume is that of the mean square radius.
#[test]
fn a_wave_by_mod_around_an_axis_is_two_leaves() {
    let text = "r = hypot(x, y)\n\
                u = z / 6 - atan2(y, x) / (2 * pi)\n\
                w = abs(mod(u + 0.5, 1) - 0.5) * 2\n\
                flank = solid(r <= 12 - (w - 0.5) * 6).name('flank') & cylinder(12).name('tip')\n\
                part(flank & box(lo=(-20, -20, -20), hi=(20, 20, 20)).name('ends'))\nmesh(size=1)\n";
    let c = at_once(text);
    let square = 0.5 * 144.0 + 0.5 * (12f64.powi(3) - 9f64.powi(3)) / 9.0;
    near(c.volume, PI * square * 40.0, 2e-3, text);
}

/// Profiles with a root whose argument changes its sign, with and without a clamp: a wall where it is zero would be a cliff.
#[test]
fn noses_by_a_square_root_are_smooth() {
    for root in ["sqrt(x)", "sqrt(max(x, 0))"] {
        let text = format!(
            "part(solid(hypot(y, z) <= 0.6 * {root}).name('nose') & solid(x <= 2).name('base'), \
             domain=((-1, -2, -2), (3, 2, 2)))\nmesh(size=0.1)\n"
        );
        let c = at_once(&text);
        assert_eq!(c.euler, 2, "{text}");
        near(c.volume, 0.36 * PI * 2.0, 5e-3, &text);
    }
    // A floor with a bowl around it, at a right angle to it.
    let text = "part(solid(z >= sqrt(max(x*x + y*y - 1, 0))).name('bowl') & box(lo=(-2, -2, -1), hi=(2, 2, 1)).name('box'))\n\
                mesh(size=0.2)\n";
    let c = at_once(text);
    // At a height z the bowl is a circle of the square radius z² + 1.
    near(c.volume, PI * (1.0 / 3.0 + 1.0), 2e-3, text);
}

/// An airfoil of four digits as every textbook has it, with a clamp at both ends and a camber line in two pieces.
#[test]
fn an_airfoil_has_a_nose_and_one_sharp_edge() {
    let text = "X = min(max(x, 0), 1)\n\
                yt = 0.6 * (0.2969 * sqrt(X) - 0.126 * X - 0.3516 * X**2 + 0.2843 * X**3 - 0.1036 * X**4)\n\
                yc = 0.125 * (0.8 * X - X**2) if x < 0.4 else 0.02 / 0.36 * (0.2 + 0.8 * X - X**2)\n\
                wing = solid(abs(z - yc) <= yt).name('skin') & solid(x >= 0) & solid(x <= 1)\n\
                part(wing & solid(y >= 0).name('root') & solid(y <= 0.5).name('tip'), domain=((-0.5, -0.2, -0.5), (1, 2, 0.5)))\n\
                mesh(size=0.05)\n";
    let c = at_once(text);
    assert_eq!(c.euler, 2);
    let section = 1.2 * (0.2969 * 2.0 / 3.0 - 0.126 / 2.0 - 0.3516 / 3.0 + 0.2843 / 4.0 - 0.1036 / 5.0);
    near(c.volume, 0.5 * section, 3e-3, text);
}

/// A formula by cases that have one value and one slope where they meet.
#[test]
fn cases_that_meet_smoothly_have_no_border() {
    let text = "c = 0.125 * (0.8 * x - x**2) if x < 0.4 else 0.02 / 0.36 * (0.2 + 0.8 * x - x**2)\n\
                part(solid(abs(z - c) <= 0.1).name('sheet') & box(lo=(0, 0, -1), hi=(0.9, 0.5, 1)).name('ends'))\n\
                mesh(size=0.05)\n";
    let c = at_once(text);
    near(c.volume, 0.2 * 0.9 * 0.5, 1e-4, text);
    assert!(c.triangles < 2000, "{}", c.triangles);
}

/// A square beside a number is a sheet with two sides: a plate written so is planes.
#[test]
fn a_sheet_by_a_square_has_two_sides() {
    let text = "part(solid(0.01 - (x - 0.2*y)**2).name('sheet') & cylinder(1, axis='x', height=2).name('rim'))\nmesh(size=0.1)\n";
    let c = at_once(text);
    near(c.volume, 0.2 * PI, 2e-3, text);
    let text =
        "part(solid((hypot(x, y) - 1)**4 <= 0.0001).name('pipe') & solid(z**2 <= 1).name('ends'))\nmesh(size=0.15)\n";
    let c = at_once(text);
    near(c.volume, PI * (1.1f64.powi(2) - 0.9f64.powi(2)) * 2.0, 5e-3, text);
}

/// Formulas whose range over half of space has no bound end, shell by shell.
#[test]
fn formulas_end_where_shells_show_it() {
    let twisted = "a = z * pi / 60\n\
                   u = x * cos(a) + y * sin(a)\n\
                   v = -x * sin(a) + y * cos(a)\n\
                   star = solid(max(abs(u), abs(v)) <= 8).name('sides') & solid(abs(u) + abs(v) <= 11).name('cut')\n\
                   part(star & solid(abs(z) <= 30).name('ends'))\nmesh(size=2)\n";
    near(at_once(twisted).volume, (256.0 - 2.0 * 25.0) * 60.0, 2e-3, twisted);
    // A ball as a sextic, with a term of degree five that its bounds over all of space cannot take.
    let sextic = "part(solid(1 - (x**2 + y**2 + z**2)**3 - 1e-9 * x**2 * z**3).name('ball'))\nmesh(size=0.1)\n";
    let c = made(sextic).report.check.unwrap();
    near(c.volume, 4.0 / 3.0 * PI, 1e-2, sextic);
    // A chair, whose terms of degree four cancel but for a fifth.
    let chair = "part(solid((x**2 + y**2 + z**2 - 23.75)**2 <= 0.8*((z-5)**2 - 2*x**2)*((z+5)**2 - 2*y**2)))\nmesh(size='3%')\n";
    let square = |v: f64| v * v;
    let inside = |[x, y, z]: [f64; 3]| {
        let ways = (square(z - 5.0) - 2.0 * x * x) * (square(z + 5.0) - 2.0 * y * y);
        0.8 * ways - square(x * x + y * y + z * z - 23.75)
    };
    near(at_once(chair).volume, counted(8.0, inside), 2e-2, chair);
    let endless = parse("part(solid(1 - x**2 + y**2 - z**2).name('hyperboloid'))\n", &[]).unwrap();
    let e = mesh_part(&endless, &MeshOptions::default(), &Run::new()).err().unwrap();
    assert!(e.to_string().contains("may be infinite"), "{e}");
}

/// Holes far smaller than the size: what is true of their edges is known as well as that of long ones.
#[test]
fn edges_of_small_holes_count_as_what_they_are() {
    let text = "plate = box(lo=(0, 0, 0), hi=(40, 40, 5)).name('plate')\n\
                h = [cylinder(1.6, at=(10 + 20*i, 10 + 20*j, 0)).name(f'h{i}{j}') for i in range(2) for j in range(2)]\n\
                part(plate - union(h))\nmesh(size=6)\n";
    let f = at_once(text).features.unwrap();
    let truth = 8.0 * 40.0 + 4.0 * 5.0 + 8.0 * 2.0 * PI * 1.6;
    assert!(relative_eq!(f.length_true, truth, epsilon = 0.0, max_relative = 2e-3), "{f:?} {truth}");
}

#[test]
fn minima_that_are_rounded_off_have_no_edge() {
    // As distance fields join balls.
    let made = made(
        "def smin(a, b, k):\n    return min(a, b) - max(k - abs(a - b), 0)**2 / (4*k)\n\
         part(solid(-smin(hypot(hypot(x, y), z) - 1, hypot(hypot(x - 1.2, y), z) - 0.7, 0.4)))\n",
    );
    let check = made.report.check.as_ref().unwrap();
    let proof = made.report.attempts[0].proof.as_ref().unwrap();
    assert_eq!((proof.unproved, check.features.as_ref().unwrap().length_true), (0, 0.0));
    // As one body without a narrow place: no more triangles than the size asks for. By leaves with an edge between them it had 45 590.
    assert!(made.mesh.triangles.len() < 7000, "{}", made.mesh.triangles.len());
}

#[test]
fn switches_deep_inside_make_edges() {
    // Two balls meet in a circle.
    let check = at_once("part(solid(1 - (abs(x) - 0.8)**2 - y**2 - z**2))");
    near(check.volume, two_balls(1.0, 1.0, 1.6), 5e-3, "balls");
    let features = check.features.unwrap();
    assert!(relative_eq!(features.length_true, 2.0 * PI * 0.6, max_relative = 0.01), "{features:?}");
    // Cylinders across each other: 16/3 of the radius cubed.
    let check = at_once("q = max(abs(x), abs(y))\npart(solid(1 - q**2 - z**2))");
    near(check.volume, 16.0 / 3.0, 5e-3, "cylinders");
}

#[test]
fn a_tapered_wing_has_the_nose_of_its_profile() {
    // The profile's thickness is scaled by the chord, which falls from the root to the tip on both sides: sections are alike.
    let profile = "c = 1 - 0.25*abs(z)\nX = (x + 0.2*abs(z))/c\n\
                   yt = 0.6*(0.2969*sqrt(X) - 0.126*X - 0.3516*X**2 + 0.2843*X**3 - 0.1036*X**4)\n\
                   part(solid(yt*c - abs(y)) & box(lo=(-1, -1, -2), hi=(1.5, 1, 2)))\n";
    let check = at_once(profile);
    let area = 2.0 * 0.6 * (0.2969 / 1.5 - 0.126 / 2.0 - 0.3516 / 3.0 + 0.2843 / 4.0 - 0.1036 / 5.0);
    // The integral of c^2 over both halves.
    let chords = 2.0 * (1.0 - 0.125) / 0.75;
    near(check.volume, area * chords, 0.01, profile);
    assert_eq!(check.features.unwrap().corners_true, 6);
}

/// Distances as they are commonly written, by functions with names of their own inside: with sharp edges, rounded off, and hollow.
#[test]
fn distances_have_the_edges_of_what_they_are_to() {
    let functions = "def block(u, v, w, a, b, c):\n\
                     \x20   p, q, r = abs(u) - a, abs(v) - b, abs(w) - c\n\
                     \x20   outside = hypot(max(p, 0), max(q, 0), max(r, 0))\n\
                     \x20   return outside + min(max(p, q, r), 0)\n\
                     def rod(u, v, w, a, h):\n\
                     \x20   p, q = hypot(u, v) - a, abs(w) - h\n\
                     \x20   return min(max(p, q), 0) + hypot(max(p, 0), max(q, 0))\n";
    let bored = format!(
        "{functions}part(solid(max(block(x, y, z, 1, 0.8, 0.5), -rod(x, y, z, 0.4, 2)) <= 0))\nmesh(size=0.1)\n"
    );
    let c = at_once(&bored);
    assert_eq!((c.euler, c.features.unwrap().corners_true), (0, 8));
    near(c.volume, 2.0 * 1.6 - 0.16 * PI, 2e-3, &bored);
    let rounded = format!("{functions}part(solid(block(x, y, z, 0.8, 0.5, 0.3) <= 0.1))\nmesh(size=0.1)\n");
    let c = at_once(&rounded);
    let [faces, edges] = [1.6 + 0.6 + 0.96, 3.2];
    let beyond = 0.2 * faces + 0.01 * PI * edges + 4.0 / 3.0 * PI * 1e-3;
    assert_eq!(c.features.unwrap().length_true, 0.0);
    near(c.volume, 0.96 + beyond, 5e-3, &rounded);
    let hollow = format!(
        "{functions}part(solid(abs(rod(x, y, z, 0.6, 0.8) + 0.1) <= 0.05) & solid(z <= 0.2))\nmesh(size=0.08)\n"
    );
    let c = at_once(&hollow);
    // Walls on both sides of the rod drawn in by 0.1.
    let part = |r: f64, low: f64| PI * r * r * (0.2 - low);
    near(c.volume, part(0.55, -0.75) - part(0.45, -0.65), 1e-2, &hollow);
}

/// The volume where a function is positive in a cube about the origin, by a grid of its signs.
fn counted(half: f64, inside: impl Fn([f64; 3]) -> f64) -> f64 {
    let n = 160;
    let h = 2.0 * half / f64::from(n);
    let at = |k: i32| -half + (f64::from(k) + 0.5) * h;
    let all = (0..n * n * n).filter(|i| inside([at(i % n), at(i / n % n), at(i / n / n)]) > 0.0);
    all.count() as f64 * h.powi(3)
}

/// A block and a ball by distances, rounded off into each other by smooth minima as they are commonly written.
#[test]
fn smooth_minima_of_blocks_have_the_edges_that_show() {
    let functions = "def smin(a, b, k):\n\
                     \x20   h = clamp(0.5 + 0.5*(b - a)/k, 0, 1)\n\
                     \x20   return b*(1 - h) + a*h - k*h*(1 - h)\n\
                     def cubic(a, b, k):\n\
                     \x20   h = max(k - abs(a - b), 0)/k\n\
                     \x20   return min(a, b) - h*h*h*k/6\n\
                     def block(u, v, w, a, b, c):\n\
                     \x20   p, q, r = abs(u) - a, abs(v) - b, abs(w) - c\n\
                     \x20   return hypot(max(p, 0), max(q, 0), max(r, 0)) + min(max(p, q, r), 0)\n\
                     base = block(x, y, z, 1, 0.8, 0.6)\n";
    let left = |a: f64, b: f64| (0.2 - (a - b).abs()).max(0.0);
    let smooth_min = |a: f64, b: f64| a.min(b) - left(a, b).powi(2) / 0.8;
    let cubic_min = |a: f64, b: f64| a.min(b) - left(a, b).powi(3) / 0.24;
    let block = |[x, y, z]: [f64; 3]| {
        let q = [x.abs() - 1.0, y.abs() - 0.8, z.abs() - 0.6];
        let beyond = q.map(|d| d.max(0.0));
        beyond[0].hypot(beyond[1]).hypot(beyond[2]) + q[0].max(q[1]).max(q[2]).min(0.0)
    };
    let ball = |p: [f64; 3], c: [f64; 3], r: f64| (p[0] - c[0]).hypot(p[1] - c[1]).hypot(p[2] - c[2]) - r;
    // What joins the ball to a face touches no edge. What is cut out of a corner leaves three edges from where it is farther than the
    // width; between the fillets they go on as creases, ever flatter, to the ball.
    let edges = 4.0 * (2.0 + 1.6 + 1.2);
    let boss = |p| [block(p), ball(p, [0.0, 0.0, 0.7], 0.3)];
    let bite = |p| [-block(p), ball(p, [1.0, 0.8, 0.6], 0.3)];
    let volume = |join: &dyn Fn(f64, f64) -> f64, of: &dyn Fn([f64; 3]) -> [f64; 2], sign: f64| {
        counted(1.3, |p| {
            let [a, b] = of(p);
            sign * join(a, b)
        })
    };
    let cases = [
        ("smin(base, hypot(x, y, z - 0.7) - 0.3, 0.2)", edges, 0.0, volume(&smooth_min, &boss, -1.0)),
        ("cubic(base, hypot(x, y, z - 0.7) - 0.3, 0.2)", edges, 0.0, volume(&cubic_min, &boss, -1.0)),
        (
            "-smin(-base, hypot(x - 1, y - 0.8, z - 0.6) - 0.3, 0.2)",
            edges - 3.0 * 0.5,
            3.0 * 0.25,
            volume(&smooth_min, &bite, 1.0),
        ),
        (
            "-cubic(-base, hypot(x - 1, y - 0.8, z - 0.6) - 0.3, 0.2)",
            edges - 3.0 * 0.5,
            3.0 * 0.25,
            volume(&cubic_min, &bite, 1.0),
        ),
    ];
    for (formula, sharp, creases, volume) in cases {
        let source = format!("{functions}d = {formula}\npart(solid(d <= 0))\nmesh(size=0.06)\n");
        let c = at_once(&source);
        let length = c.features.unwrap().length_true;
        assert!(length >= sharp - 5e-3 * edges && length <= sharp + creases + 5e-3 * edges, "{formula}: {length}");
        near(c.volume, volume, 6e-3, formula);
    }
}

/// A bellows cut where its wave turns back: the wall bends across the plane there, and its volume is that of a plain tube.
#[test]
fn a_wall_that_bends_across_a_plane_leaves_no_islands() {
    let text = "rho = hypot(x, y)\n\
                part(solid(abs(rho - 8 - 4 * sin(2 * pi * z / 8)) <= 0.8) & solid(abs(z - 26) <= 4))\n\
                mesh(size='2%')\n";
    let c = at_once(text);
    assert_eq!((c.components, c.euler), (1, 0));
    near(c.volume, PI * (8.8 * 8.8 - 7.2 * 7.2) * 8.0, 2e-3, text);
}

/// A Fresnel lens whose last step lies on its rim: the formula has a sheet without thickness there, which is no part of the solid.
#[test]
fn a_step_on_the_rim_leaves_nothing_lost() {
    let text = "r = hypot(x, y)\n\
                ring = floor(r / 1.5)\n\
                h = 2.6 - 0.02 * (r**2 - (1.5 * ring)**2)\n\
                part(solid(z <= h) & solid(z >= 0) & cylinder(9, height=20))\n\
                mesh(size='2%')\n";
    let c = at_once(text);
    assert_eq!((c.components, c.euler), (1, 2));
    let ring = |k: i32| {
        let (a, b) = (1.5 * f64::from(k), 1.5 * f64::from(k + 1));
        let area = b * b - a * a;
        PI * (2.6 * area - 0.01 * (b.powi(4) - a.powi(4)) + 0.02 * a * a * area)
    };
    near(c.volume, (0..6).map(ring).sum(), 1e-3, text);
}

/// Between a block, by its distance, and a ball: where the ball is outside, the surface is within the block and has its edges. Elsewhere
/// these are rounded off by as much as the surface is away from the block. And a block with waves on it, whose edges are sharp where they are
/// dents.
#[test]
fn distances_with_functions_beside_them_have_edges_within() {
    let text = "qx, qy, qz = abs(x) - 0.8, abs(y) - 0.7, abs(z) - 0.5\n\
                block = sqrt(max(qx, 0)**2 + max(qy, 0)**2 + max(qz, 0)**2) + min(max(qx, qy, qz), 0)\n\
                ball = sqrt((x - 0.5)**2 + (y - 0.4)**2 + (z - 0.45)**2) - 0.6\n\
                part(solid(block * 0.6 + ball * 0.4 <= 0))\n\
                mesh(size='3%')\n";
    let c = at_once(text);
    let d = c.deviation.unwrap();
    assert!(d.max.max(d.from_surface.unwrap()) < 0.02, "{d:?}");
    let block = |[x, y, z]: [f64; 3]| {
        let q = [x.abs() - 0.8, y.abs() - 0.7, z.abs() - 0.5];
        let beyond = q.map(|d| d.max(0.0));
        beyond[0].hypot(beyond[1]).hypot(beyond[2]) + q[0].max(q[1]).max(q[2]).min(0.0)
    };
    let ball = |[x, y, z]: [f64; 3]| (x - 0.5).hypot(y - 0.4).hypot(z - 0.45) - 0.6;
    near(c.volume, counted(1.0, |p| -0.6 * block(p) - 0.4 * ball(p)), 5e-3, text);
    // Far away the slope alone tells that it ends, which no interval shows: the box comes from elsewhere.
    let tilted = "p, q, r = abs(x) - 0.8, abs(y) - 0.7, abs(z) - 0.5\n\
                  block = hypot(max(p, 0), max(q, 0), max(r, 0)) + min(max(p, q, r), 0)\n\
                  part(solid(block + 0.3 * z <= 0) & sphere(2))\n\
                  mesh(size='3%')\n";
    let report = made(tilted).report;
    assert!(report.shortfalls.is_empty(), "{:?}", report.shortfalls);
    let c = report.check.unwrap();
    assert!(c.features.unwrap().recall > 0.99, "{:?}", c.features);
    near(c.volume, counted(1.1, |p| -block(p) - 0.3 * p[2]), 5e-3, tilted);
    let waves = "p, q, r = abs(x) - 0.8, abs(y) - 0.7, abs(z) - 0.5\n\
                 block = hypot(max(p, 0), max(q, 0), max(r, 0)) + min(max(p, q, r), 0)\n\
                 part(solid(block + 0.1 * sin(3 * x) <= 0))\n\
                 mesh(size='3%')\n";
    let c = at_once(waves);
    near(c.volume, counted(1.0, |p| -block(p) - 0.1 * (3.0 * p[0]).sin()), 5e-3, waves);
    // Where x is positive the four edges along it go inward by the sine, and to the face ahead, which is as much farther back.
    let ahead = 0.8 - 0.1 * (3.0_f64 * 0.73).sin();
    let lower = 0.1 * (3.0 * ahead).sin();
    let along = 4.0 * ahead + 4.0 * (1.2 - 2.0 * lower);
    let f = c.features.unwrap();
    assert!((f.length_true - along).abs() < 0.05 * along, "{f:?} {along}");
}
