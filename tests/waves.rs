//! Formulas that repeat by `mod` or jump with an angle: rows of slots and holes, springs, knurls; cams, ratchets, ramps. Surfaces at
//! which `mod` jumps are none of the part's; walls at which `atan2` jumps are, where the formula shows them.

use std::f64::consts::PI;

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq};
use rvachev::implicit::part::parse;
use rvachev::pipeline::{MeshOptions, Meshed, SizeRequest, mesh_part};
use rvachev::quality::Check;
use rvachev::{DVec3, Run};

/// The part's mesh, which comes out at the first attempt with all edges and corners.
fn meshed(text: &str, share: f64) -> (Meshed, Check) {
    let part = parse(text, &[]).unwrap();
    let options = MeshOptions { size: Some(SizeRequest::Share(share)), ..MeshOptions::default() };
    let meshed = mesh_part(&part, &options, &Run::new()).unwrap();
    let check = meshed.report.check.clone().unwrap();
    let report = &meshed.report;
    assert_eq!((report.method, report.attempts.len(), &report.shortfalls), ("leaf", 1, &Vec::new()), "{text}");
    assert!(check.certificate.is_sound(), "{:?}", check.certificate);
    (meshed, check)
}

#[test]
fn rows_of_slots_are_cut_out_as_they_are_left_standing() {
    // Slots of 0.8 in steps of one: of three the outer ones are cut by the plate's ends.
    let slots = "slots = solid(abs(mod(x + 0.5, 1) - 0.5) <= 0.4).name('slots') & box(size=(5, 1, 1)).name('ends')\n\
                 plate = box(size=(2.6, 2.4, 0.24)).name('plate')\n";
    let cut = 0.24 * (0.7 + 0.8 + 0.7);
    for (operation, volume, corners) in
        [("part(plate - slots)", 2.6 * 2.4 * 0.24 - cut, 32), ("part(plate & slots)", cut, 24)]
    {
        let (_, check) = meshed(&format!("{slots}{operation}"), 0.04);
        assert!(abs_diff_eq!(check.volume.unwrap(), volume, epsilon = 1e-12), "{operation}: {:?}", check.volume);
        let features = check.features.unwrap();
        assert_eq!((features.corners_found, features.corners_true), (corners, corners), "{operation}");
        assert!(features.recall > 0.999 && features.precision > 0.999, "{operation}: {features:?}");
    }
}

#[test]
fn hexagonal_holes_repeat_in_two_directions() {
    let text = "def hexagon(a, b):\n    return max(abs(a), abs(a)/2 + abs(b)*sqrt(3)/2)\n\
                s = sqrt(3)\n\
                first = hexagon(mod(x + 0.5, 1) - 0.5, mod(y + s/2, s) - s/2)\n\
                second = hexagon(mod(x, 1) - 0.5, mod(y, s) - s/2)\n\
                plate = box(size=(3, 3, 0.3)).name('plate')\n\
                part(plate - solid(min(first, second) <= 0.4).name('holes'))\n";
    let (_, check) = meshed(text, 0.04);
    // Hexagons of inradius 0.4, three in the middle row. At y = -0.866 and 0.866 are two, and halves at the sides of the plate. Of three at
    // y = -1.732 and 1.732 there are the tips.
    let (hole, beyond) = (2.0 * 3f64.sqrt() * 0.16, 3f64.sqrt() - 1.5);
    let tip = (0.8 - 3f64.sqrt() * beyond) * (0.8 / 3f64.sqrt() - beyond);
    let volume = 0.3 * (9.0 - 9.0 * hole - 6.0 * tip);
    assert_abs_diff_eq!(check.volume.unwrap(), volume, epsilon = 1e-9);
}

#[test]
fn a_spring_by_mod_is_one_smooth_wire() {
    // By planes through the axis the wire's sections are circles: each turn has the volume of a ring.
    let (radius, wire, pitch) = (8.0, 1.1, 4.0);
    // The second wire is half a turn higher.
    for (off, higher) in
        [("mod(z - 4*atan2(y, x)/(2*pi) + 2, 4) - 2", 0.0), ("abs(mod(z - 4*atan2(y, x)/(2*pi), 4) - 2)", 2.0)]
    {
        let text = format!(
            "part(solid(hypot(hypot(x, y) - {radius}, {off}) <= {wire}).name('wire') & \
             box(lo=(-10, -10, -{pitch}), hi=(10, 10, {pitch})).name('ends'))"
        );
        let (meshed, check) = meshed(&text, 0.03);
        let volume = 2.0 * (2.0 * PI * radius) * (PI * wire * wire);
        // Nodes lie on the wire: its chords, some fifteen around it, take a hundredth or more.
        let share = check.volume.unwrap() / volume;
        assert!((0.98..1.0).contains(&share), "{off}: {:?}, in truth {volume}", check.volume);
        let features = check.features.unwrap();
        assert!(features.recall > 0.999 && features.precision > 0.999, "{off}: {features:?}");
        // Where `mod` jumps, between the turns, there is nothing.
        let labels = meshed.mesh.faces.iter().position(|f| f == "wire").unwrap() as u32;
        let wire_only = meshed.mesh.triangles.iter().zip(&meshed.mesh.labels).filter(|t| *t.1 == labels);
        for v in wire_only.flat_map(|t| *t.0) {
            let p = meshed.mesh.nodes[v as usize];
            let turn = p.z - higher - pitch * p.y.atan2(p.x) / (2.0 * PI);
            let off = turn - pitch * (turn / pitch).round();
            assert!(abs_diff_eq!((p.x.hypot(p.y) - radius).hypot(off), wire, epsilon = 1e-9), "{p}");
        }
    }
}

#[test]
fn knurls_are_proved_in_cells_as_large_as_their_waves_allow() {
    let text = "r = hypot(x, y)\npace = 2*pi/36\n\
                wave = abs(mod(atan2(y, x) + z/14, pace) - pace/2)\n\
                part(solid(r <= 12.6 - 8*wave).name('grip') & box(lo=(-20, -20, 0), hi=(20, 20, 1)).name('ends'))\n";
    let (meshed, check) = meshed(text, 0.03);
    // The mean of (12.6 - 8 w)^2 over w from 0 to pi/36, for each angle.
    let most = 8.0 * PI / 36.0;
    let mean = 12.6 * 12.6 - 12.6 * most + most * most / 3.0;
    assert_relative_eq!(check.volume.unwrap(), PI * mean, epsilon = 0.0, max_relative = 2e-3);
    let proof = meshed.report.attempts[0].proof.as_ref().unwrap();
    // Deep inside the surfaces that part the waves make no difference: cells there hold nothing of the part's.
    assert!(proof.unproved == 0 && proof.cells < 60_000, "{} of {}", proof.unproved, proof.cells);
}

/// The nodes of triangles that lie in a plane through the axis, which is turned by so many turns from the half plane behind.
fn on_wall(meshed: &Meshed, turns: f64) -> Vec<DVec3> {
    let (sin, cos) = (turns * 2.0 * PI).sin_cos();
    let beside = |p: DVec3| p.y * cos - p.x * sin;
    let at = |v: u32| meshed.mesh.nodes[v as usize];
    let is_on = |t: &&[u32; 3]| t.iter().all(|v| beside(at(*v)).abs() < 1e-9 && at(*v).x * cos + at(*v).y * sin < 0.0);
    meshed.mesh.triangles.iter().filter(is_on).flatten().map(|v| at(*v)).collect()
}

#[test]
fn a_cam_has_its_step_where_the_angle_jumps() {
    let text = "part(solid(hypot(x, y) <= 1 + atan2(y, x)/(4*pi)).name('cam') & box(size=(4, 4, 0.5)).name('ends'))";
    let (meshed, check) = meshed(text, 0.02);
    // The mean of (1 + t / 2)^2 / 2 for t from -1/2 to 1/2, around the axis.
    let volume = 0.5 * 2.0 * PI * 0.5 * (1.0 + 1.0 / 48.0);
    assert_relative_eq!(check.volume.unwrap(), volume, epsilon = 0.0, max_relative = 1e-3);
    let features = check.features.unwrap();
    assert_eq!((features.corners_found, features.corners_true), (4, 4));
    assert!(features.recall > 0.999 && features.precision > 0.999, "{features:?}");
    // The step is a rectangle from the least radius to the largest.
    let wall = on_wall(&meshed, 0.0);
    let (near, far) = wall.iter().fold((f64::INFINITY, 0f64), |(a, b), p| (a.min(-p.x), b.max(-p.x)));
    assert_abs_diff_eq!(near, 0.75, epsilon = 1e-9);
    assert_abs_diff_eq!(far, 1.25, epsilon = 1e-9);
    let proof = meshed.report.attempts[0].proof.as_ref().unwrap();
    assert_eq!(proof.unproved, 0);
}

#[test]
fn teeth_of_a_ratchet_rise_and_fall_back() {
    let text = "part(solid(hypot(x, y) <= 1 + 0.03*atan2(sin(12*atan2(y, x)), cos(12*atan2(y, x)))).name('teeth') & \
                box(size=(4, 4, 0.3)).name('ends'))";
    let (meshed, check) = meshed(text, 0.02);
    let most = 0.03 * PI;
    let volume = 0.3 * PI * (1.0 + most * most / 3.0);
    assert_relative_eq!(check.volume.unwrap(), volume, epsilon = 0.0, max_relative = 1e-3);
    let features = check.features.unwrap();
    assert_eq!((features.corners_found, features.corners_true), (48, 48));
    for k in 0..12 {
        let wall = on_wall(&meshed, (f64::from(k) + 0.5) / 12.0 + 0.5);
        let (near, far) = wall.iter().map(|p| p.x.hypot(p.y)).fold((2f64, 0f64), |(a, b), r| (a.min(r), b.max(r)));
        assert!((near - 1.0 + most).abs() < 1e-9 && (far - 1.0 - most).abs() < 1e-9, "{k}: {near} {far}");
    }
}

#[test]
fn a_ramp_around_a_bore_ends_in_a_wall() {
    let text = "part(solid(z <= 0.3*atan2(y, x)).name('ramp') & cylinder(1, height=3).name('drum') - cylinder(0.2).name('bore'))";
    let (meshed, check) = meshed(text, 0.02);
    // The ramp's mean height is that of the middle.
    let volume = 1.5 * PI * (1.0 - 0.04);
    assert_relative_eq!(check.volume.unwrap(), volume, epsilon = 0.0, max_relative = 1e-3);
    let features = check.features.unwrap();
    assert_eq!((features.corners_found, features.corners_true), (4, 4));
    let wall = on_wall(&meshed, 0.0);
    let high = wall.iter().fold(0f64, |s, p| s.max(p.z.abs()));
    assert_abs_diff_eq!(high, 0.3 * PI, epsilon = 1e-9);
    let proof = meshed.report.attempts[0].proof.as_ref().unwrap();
    assert_eq!(proof.unproved, 0);
}

#[test]
fn round_holes_that_repeat_are_proved_where_they_are_cut_out() {
    // A formula without a switch, subtracted: what is below its seams is the plate's.
    let text = "u = mod(x + 0.5, 1) - 0.5\nv = mod(y + 0.5, 1) - 0.5\n\
                part(box(size=(3, 3, 0.2)).name('plate') - solid(hypot(u, v) <= 0.3).name('holes'))\n";
    let (meshed, check) = meshed(text, 0.03);
    let proof = meshed.report.attempts[0].proof.as_ref().unwrap();
    assert!(proof.unproved == 0 && proof.cells < 2000, "{proof:?}");
    let features = check.features.unwrap();
    assert_eq!((features.corners_found, features.corners_true), (8, 8));
    assert!(features.recall > 0.999 && features.precision > 0.999, "{features:?}");
    let holes = meshed.mesh.faces.iter().position(|f| f == "holes").unwrap() as u32;
    let walls = meshed.mesh.triangles.iter().zip(&meshed.mesh.labels).filter(|t| *t.1 == holes);
    for v in walls.flat_map(|t| *t.0) {
        let p = meshed.mesh.nodes[v as usize];
        assert_abs_diff_eq!((p.x - p.x.round()).hypot(p.y - p.y.round()), 0.3, epsilon = 1e-9);
    }
    // Chords of the holes' walls, some twenty around, leave a hundredth of their area standing or less.
    let cut = 9.0 * PI * 0.09 * 0.2;
    let off = (check.volume.unwrap() - (9.0 * 0.2 - cut)) / cut;
    assert!((0.0..0.02).contains(&off), "{off}");
}

#[test]
fn treads_around_an_axis_need_no_box() {
    // Twelve treads: what bounds them from below and above is their own formulas.
    let text = "step = floor(atan2(y, x)*6/pi)*0.25\n\
                part((solid(z <= step + 2).name('top') & solid(z >= step + 1.7).name('bottom') & cylinder(3)) - cylinder(0.8))\n";
    let (meshed, check) = meshed(text, 0.04);
    assert_eq!(meshed.report.attempts[0].proof.as_ref().unwrap().unproved, 0);
    let features = check.features.unwrap();
    // A tread overlaps the next one by a sixth of its thickness: sides have corners there. The ends of the stairs have 8 more.
    assert_eq!((features.corners_found, features.corners_true), (11 * 8 + 8, 11 * 8 + 8));
    assert!(features.recall > 0.999 && features.precision > 0.99, "{features:?}");
    let volume = PI * (9.0 - 0.64) * 0.3;
    assert_relative_eq!(check.volume.unwrap(), volume, epsilon = 0.0, max_relative = 5e-3);
}

#[test]
fn a_thread_is_exact_however_its_wave_is_written() {
    // At each height the wave takes all its values evenly around the axis.
    let section = PI * ((2.5f64.powi(3) - 1.6f64.powi(3)) / 3.6 + 0.25 * 6.25);
    for wave in [
        "w = mod(u, 2)\nwave = min(w, 2 - w)",
        "wave = 2*abs(u/2 - round(u/2))",
        "wave = abs(u - 2*floor(u/2) - 1)\nwave = 1 - wave",
        "wave = acos(cos(pi*u))/pi",
    ] {
        let text = format!(
            "u = z - atan2(y, x)/pi\n{wave}\nthread = solid(hypot(x, y) <= 1.6 + 1.2*wave)\n\
             part(thread & cylinder(2.5, height=9).name('crest'))"
        );
        let (_, check) = meshed(&text, 0.04);
        // Chords of a crest 22 edges around.
        let share = check.volume.unwrap() / (9.0 * section);
        assert!((0.98..1.0).contains(&share), "{wave}: {share}");
        let features = check.features.unwrap();
        assert!(features.recall > 0.99 && features.precision > 0.99, "{wave}: {features:?}");
    }
}
