//! What pictures must show, read off their pixels.

use approx::assert_abs_diff_eq;
use glam::DVec3;

use super::*;

/// An axis-parallel box with one face per side.
fn box_mesh() -> TriMesh {
    let nodes = (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64)).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut mesh = TriMesh { nodes, ..Default::default() };
    for (face, [a, b, c, d]) in quads.into_iter().enumerate() {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
        mesh.labels.extend([face as u32; 2]);
    }
    mesh.faces = ["x-", "x+", "y-", "y+", "z-", "z+"].map(String::from).to_vec();
    mesh
}

fn pixel(p: &Picture, x: usize, y: usize) -> [u8; 3] {
    let at = 3 * (y * p.width + x);
    [p.rgb[at], p.rgb[at + 1], p.rgb[at + 2]]
}

fn plain(size: usize, towards: DVec3) -> RenderOptions {
    RenderOptions {
        width: size,
        height: size,
        view: View { towards, up: DVec3::Z, margin: 0.1, focus: None },
        wireframe: Some(false),
        sharp_angle: None,
        legend: false,
        ..Default::default()
    }
}

/// How many pixels look like the color.
fn count(p: &Picture, like: impl Fn([u8; 3]) -> bool) -> usize {
    p.rgb.chunks_exact(3).filter(|c| like([c[0], c[1], c[2]])).count()
}

fn red(c: [u8; 3]) -> bool {
    c[0] > 190 && c[1] < 60 && c[2] < 70
}

fn dark(c: [u8; 3]) -> bool {
    c.iter().all(|c| *c < 70)
}

#[test]
fn a_side_fills_its_square_and_nothing_else() {
    for towards in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z] {
        let p = render(&box_mesh(), &plain(100, towards), &Run::new()).unwrap();
        let background = pixel(&p, 0, 0);
        let side = pixel(&p, 50, 50);
        assert_ne!(side, background);
        for y in 0..100 {
            for x in 0..100 {
                let inside = (10..90).contains(&x) && (10..90).contains(&y);
                assert_eq!(pixel(&p, x, y), if inside { side } else { background }, "{towards} {x} {y}");
            }
        }
    }
}

#[test]
fn nearer_triangles_hide_farther_ones_in_any_order() {
    let mut mesh = box_mesh();
    let p = render(&mesh, &plain(64, View::default().towards), &Run::new()).unwrap();
    mesh.triangles.reverse();
    mesh.labels.reverse();
    assert_eq!(render(&mesh, &plain(64, View::default().towards), &Run::new()).unwrap(), p);
}

#[test]
fn threads_do_not_change_a_byte() {
    let options = RenderOptions { width: 300, height: 200, ..Default::default() };
    let one = render(&box_mesh(), &options, &Run::new().with_threads(1).unwrap()).unwrap();
    let three = render(&box_mesh(), &options, &Run::new().with_threads(3).unwrap()).unwrap();
    assert_eq!(one, three);
}

#[test]
fn visible_sharp_edges_are_dark_and_hidden_ones_absent() {
    let options = RenderOptions { sharp_angle: Some(30.0), ..plain(400, View::default().towards) };
    let p = render(&box_mesh(), &options, &Run::new()).unwrap();
    let [right, up, _] = options.view.axes().unwrap();
    let center = DVec3::splat(0.5);
    let corners = crate::spatial::Aabb::new(DVec3::ZERO, DVec3::ONE).corners();
    let reach = |axis: DVec3| corners.iter().map(|c| axis.dot(*c - center)).fold(0.0, f64::max);
    let scale = 320.0 / (2.0 * reach(right).max(reach(up)));
    let at = |q: DVec3| {
        let d = q - center;
        pixel(&p, (200.0 + scale * right.dot(d)) as usize, (200.0 - scale * up.dot(d)) as usize)
    };
    // The three visible edges meet at (1, 0, 1), the three hidden ones at (0, 1, 0).
    for axis in [-DVec3::X, DVec3::Y, -DVec3::Z] {
        assert!(dark(at(DVec3::new(1.0, 0.0, 1.0) + 0.5 * axis)));
        assert!(!dark(at(DVec3::new(0.0, 1.0, 0.0) - 0.3 * axis)));
    }
    let smooth = RenderOptions { sharp_angle: Some(100.0), ..options };
    let borders = render(&box_mesh(), &smooth, &Run::new()).unwrap();
    assert!(count(&borders, dark) < count(&p, dark));
}

#[test]
fn boundaries_are_red_and_backs_are_grey() {
    let options = RenderOptions { sharp_angle: Some(30.0), ..plain(300, View::default().towards) };
    let closed = render(&box_mesh(), &options, &Run::new()).unwrap();
    let mut mesh = box_mesh();
    // Without its top the box is open above: its rim is red, its inner walls are seen from behind.
    mesh.triangles.truncate(10);
    mesh.labels.truncate(10);
    let open = render(&mesh, &options, &Run::new()).unwrap();
    assert_eq!(count(&closed, red), 0);
    assert!(count(&open, red) > 400);
    assert!(count(&open, grey) > 10 * count(&closed, grey).max(100));
}

#[test]
fn touching_faces_differ_and_equal_names_agree() {
    let mesh = box_mesh();
    let look = palette::TriangleColors::new(&mesh, &ColorBy::Face);
    let colors: Vec<_> = (0..12).step_by(2).map(|t| look.color(&mesh, t)).collect();
    for i in 0..6 {
        assert!((0..i).all(|j| colors[i] != colors[j]));
    }
    // The same names in another order keep their colors.
    let mut turned = box_mesh();
    turned.faces.rotate_left(2);
    turned.labels.iter_mut().for_each(|l| *l = (*l + 4) % 6);
    let look = palette::TriangleColors::new(&turned, &ColorBy::Face);
    assert!((0..6).all(|i| look.color(&turned, 2 * i) == colors[i]));
}

#[test]
fn quality_goes_from_red_to_blue() {
    let nodes = vec![DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.75f64.sqrt(), 0.0), DVec3::new(0.5, 0.01, 0.0)];
    let mesh = TriMesh::new(nodes, vec![[0, 1, 2], [0, 1, 3], [0, 1, 1]]);
    let look = palette::TriangleColors::new(&mesh, &ColorBy::Angle);
    let clipping = clip::Clipping::new(&mesh, &[], DVec3::X).unwrap();
    assert_eq!(look.legend(&mesh, &clipping, [600, 400]).unwrap().lines.len(), 8);
    let [good, bad, worst] = [0, 1, 2].map(|t| look.color(&mesh, t));
    assert!(good[2] > good[0] && bad[0] > 2.0 * bad[2] && worst[0] > 2.0 * worst[2]);
}

#[test]
fn legends_name_the_faces() {
    let options = RenderOptions { width: 400, height: 300, ..Default::default() };
    let with = render(&box_mesh(), &options, &Run::new()).unwrap();
    let without = render(&box_mesh(), &RenderOptions { legend: false, ..options }, &Run::new()).unwrap();
    let right = |p: &Picture| {
        (0..300).flat_map(|y| (360..400).map(move |x| (x, y))).filter(|(x, y)| dark(pixel(p, *x, *y))).count()
    };
    assert!(right(&with) > 100 && right(&without) < 30);
}

#[test]
fn sixty_long_names_stay_in_their_place() {
    let mut mesh = TriMesh::default();
    for i in 0..60u32 {
        let corner = DVec3::new(f64::from(i % 10), f64::from(i / 10), 0.0);
        mesh.nodes.extend([corner, corner + 0.8 * DVec3::X, corner + 0.8 * DVec3::Y]);
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        mesh.labels.push(i);
        mesh.faces.push(format!("assembly.bracket.rather.long.name.of.face.{i}"));
    }
    for size in [[600, 400], [300, 200], [1200, 900]] {
        let [width, height] = size;
        let view = View { margin: 0.0, ..View::from_angles(0.0, 90.0) };
        let options = RenderOptions { width, height, view, sharp_angle: None, ..Default::default() };
        let p = render(&mesh, &options, &Run::new()).unwrap();
        let look = palette::TriangleColors::new(&mesh, &ColorBy::Face);
        let clipping = clip::Clipping::new(&mesh, &[], DVec3::Z).unwrap();
        let legend = look.legend(&mesh, &clipping, size).unwrap();
        let shown = legend.lines.len() - 1;
        assert!(shown >= 5 && legend.lines[0].1.contains('…') && legend.lines[0].1.ends_with(".0"));
        let more = 60 - shown;
        assert!([format!("and {more} more"), format!("+{more}")].contains(&legend.lines[shown].1));
        // The mesh has the left part for itself, and the text keeps away from the borders.
        let room = width - legend.width;
        assert!(5 * room >= 3 * width);
        let alone = RenderOptions { width: room, legend: false, ..options };
        let alone = render(&mesh, &alone, &Run::new()).unwrap();
        let ground = pixel(&p, width - 1, 0);
        let mut text = 0;
        for y in 0..height {
            assert!((0..room).all(|x| pixel(&p, x, y) == pixel(&alone, x, y)));
            let border = |x: &usize| *x >= width - 8 || !(8..height - 8).contains(&y);
            assert!((room..width).filter(border).all(|x| pixel(&p, x, y) == ground));
            text += (room..width).filter(|x| dark(pixel(&p, *x, y))).count();
        }
        assert!(text > 500);
    }
    assert_eq!(picture::shortened("abcdefghij", 5), "ab…ij");
    assert_eq!(picture::shortened("abcdefghij", 1), "…");
    assert_eq!(picture::shortened("abcdefghij", 0), "");
    assert_eq!(picture::shortened("abcdefghij", 10), "abcdefghij");
}

#[test]
fn named_views_show_their_side_upright() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let views = [
        ("front", "0,0", 2, [x, z]),
        ("back", "180,0", 3, [-x, z]),
        ("left", "-90,0", 0, [-y, z]),
        ("right", "450,0", 1, [y, z]),
        ("top", "0,90", 5, [x, y]),
        ("bottom", "0,-90", 4, [x, -y]),
    ];
    let mesh = box_mesh();
    let look = palette::TriangleColors::new(&mesh, &ColorBy::Face);
    for (name, angles, face, [right, up]) in views {
        let view: View = name.parse().unwrap();
        assert_eq!(angles.parse::<View>().unwrap(), view);
        assert_eq!(view.axes().unwrap(), [right, up, right.cross(up)], "{name}");
        let options = RenderOptions { view: View { margin: 0.1, ..view }, ..plain(100, DVec3::X) };
        let p = render(&mesh, &options, &Run::new()).unwrap();
        let side = pixel(&p, 50, 50);
        assert_eq!(count(&p, |c| c == side), 80 * 80);
        // Seen straight on a face is a little brighter than its color.
        let color = look.color(&mesh, 2 * face).map(|c| c * 255.0);
        assert!((0..3).all(|k| (f32::from(side[k]) - color[k]).abs() < 10.0), "{name} {side:?} {color:?}");
    }
    let iso: View = "iso".parse().unwrap();
    let [a, b, c] = iso.towards.to_array();
    assert_abs_diff_eq!(a, -b, epsilon = 1e-15);
    assert_abs_diff_eq!(a, c, epsilon = 1e-15);
    assert!(a > 0.5);
    for bad in ["", "up", "Front", "1", "1,2,3", "0,91", "nan,0", "0,inf", "0;0"] {
        let said = bad.parse::<View>().unwrap_err().to_string();
        assert!(said.contains("front") && said.contains("bottom") && said.contains("ELEVATION"), "{said}");
    }
}

/// What the triangles' backs look like.
fn grey(c: [u8; 3]) -> bool {
    c[0].abs_diff(c[1]) < 20 && c[1].abs_diff(c[2]) < 6 && (60..160).contains(&c[0])
}

#[test]
fn clipping_opens_a_box() {
    let drawn = |clips: &[&str], view: &str, sharp_angle: Option<f64>| {
        let view = View { margin: 0.1, ..view.parse().unwrap() };
        let clips = clips.iter().map(|c| c.parse().unwrap()).collect();
        render(&box_mesh(), &RenderOptions { view, clips, sharp_angle, ..plain(200, DVec3::X) }, &Run::new())
    };
    // Straight into the box: its back fills the square. From the other half the outside is seen as without a plane.
    let p = drawn(&["x=0.5"], "right", None).unwrap();
    assert_eq!(count(&p, grey), 160 * 160);
    assert_eq!(p, drawn(&["x=0.25,below"], "right", None).unwrap());
    assert_eq!(drawn(&["x=0.5,above"], "right", None).unwrap(), drawn(&[], "right", None).unwrap());
    // Half of the front, exactly; a quarter with one more plane.
    let ground = pixel(&p, 0, 0);
    let covered = |p: &Picture| count(p, |c| c != ground);
    assert_eq!(covered(&drawn(&["z=0.5,above"], "front", None).unwrap()), 160 * 80);
    assert_eq!(covered(&drawn(&["z=0.5", "x=0.75,above"], "front", None).unwrap()), 160 * 80);
    // From 45 degrees above, the opening takes two thirds of what is seen, and the front the rest; pixels along borders mix.
    let p = drawn(&["z=0.5"], "0,45", None).unwrap();
    let share = count(&p, grey) as f64 / covered(&p) as f64;
    assert_abs_diff_eq!(share, 2.0 / 3.0, epsilon = 0.015);
    // The cut has a dark outline, and no open boundary.
    let p = drawn(&["z=0.5"], "top", Some(30.0)).unwrap();
    assert_eq!(count(&p, red), 0);
    assert!(dark(pixel(&p, 100, 20)) && dark(pixel(&p, 20, 60)) && !dark(pixel(&p, 100, 100)));
    // What would do nothing, or leave nothing, is refused.
    for (clips, said) in [
        (&["x=1"][..], "between x = 0 and x = 1"),
        (&["z=0,above"], "between z = 0 and z = 1"),
        (&["y=0.5", "y=0.6"], "same side"),
        (&["y=0.3,below", "y=0.6,above"], "nothing"),
    ] {
        match drawn(clips, "iso", None) {
            Err(Error::Usage(message)) => assert!(message.contains(said), "{message}"),
            other => panic!("{clips:?}: {other:?}"),
        }
    }
    for bad in ["", "x", "x=", "w=0", "x=nan", "x=0,left", "x<0", "x=0,below,above"] {
        assert!(bad.parse::<ClipPlane>().unwrap_err().to_string().contains("AXIS=POSITION,above"));
    }
}

#[test]
fn faces_in_the_plane_stay_with_their_solid() {
    // Two boxes on top of each other: the lid of the lower one and the bottom of the upper one are in one plane.
    let (mut mesh, upper) = (box_mesh(), box_mesh());
    mesh.nodes.extend(upper.nodes.iter().map(|p| *p + DVec3::Z));
    mesh.triangles.extend(upper.triangles.iter().map(|t| t.map(|v| v + 8)));
    mesh.labels.extend(&upper.labels);
    for (clip, view) in [("z=1,below", "top"), ("z=1,above", "bottom")] {
        let view = View { margin: 0.1, ..view.parse().unwrap() };
        let options = RenderOptions { view, clips: vec![clip.parse().unwrap()], ..plain(100, DVec3::X) };
        let whole = RenderOptions { clips: Vec::new(), ..options.clone() };
        let p = render(&mesh, &options, &Run::new()).unwrap();
        assert_eq!(count(&p, grey), 0);
        assert_eq!(p, render(&mesh, &whole, &Run::new()).unwrap());
    }
}

#[test]
fn transparent_backgrounds_have_no_opacity() {
    let solid = plain(100, DVec3::X);
    let options = RenderOptions { transparent: true, ..solid.clone() };
    let p = render(&box_mesh(), &options, &Run::new()).unwrap();
    let opaque = render(&box_mesh(), &solid, &Run::new()).unwrap();
    assert_eq!(opaque.alpha, None);
    let alpha = p.alpha.as_ref().unwrap();
    for y in 0..100 {
        for x in 0..100 {
            let inside = (10..90).contains(&x) && (10..90).contains(&y);
            assert_eq!(alpha[100 * y + x], if inside { 255 } else { 0 });
            assert!(!inside || pixel(&p, x, y) == pixel(&opaque, x, y));
        }
    }
    // Half-covered pixels keep their color and have half the opacity.
    let half = RenderOptions { view: View { margin: 0.105, ..options.view }, ..options.clone() };
    let half = render(&box_mesh(), &RenderOptions { samples: 2, ..half }, &Run::new()).unwrap();
    let (at, color) = (100 * 10 + 50, pixel(&half, 50, 50));
    assert_eq!((half.alpha.as_ref().unwrap()[at], pixel(&half, 50, 10)), (128, color));
    let bytes = p.png_bytes().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    assert_eq!(reader.next_frame(&mut pixels).unwrap().color_type, png::ColorType::Rgba);
    assert!(pixels.chunks_exact(4).map(|c| c[3]).eq(alpha.iter().copied()));
    assert!(Picture { alpha: Some(vec![0; 7]), ..p }.png_bytes().is_err());
    // Legends are opaque, and threads change nothing.
    let clips = vec!["z=0.3".parse().unwrap()];
    let all = RenderOptions { width: 400, height: 300, clips, transparent: true, ..Default::default() };
    let one = render(&box_mesh(), &all, &Run::new().with_threads(1).unwrap()).unwrap();
    assert!(
        one.rgb
            .chunks_exact(3)
            .zip(one.alpha.as_ref().unwrap())
            .skip(360)
            .step_by(400)
            .all(|(_, a)| *a == 0 || *a == 255)
    );
    assert_eq!(one, render(&box_mesh(), &all, &Run::new().with_threads(3).unwrap()).unwrap());
}

#[test]
fn lengths_and_distances_have_scales_of_their_own() {
    // A small and a large triangle; the mean edge lies between.
    let at = |x: f64, s: f64| [DVec3::new(x, 0.0, 0.0), DVec3::new(x + s, 0.0, 0.0), DVec3::new(x, s, 0.0)];
    let mesh = TriMesh::new([at(0.0, 1.0), at(2.0, 9.0)].concat(), vec![[0, 1, 2], [3, 4, 5]]);
    let look = palette::TriangleColors::new(&mesh, &ColorBy::Edge);
    let [small, large] = [0, 1].map(|t| look.color(&mesh, t));
    assert!(small[2] > 1.5 * small[0] && large[0] > 1.5 * large[2]);
    let by = ColorBy::Distance(vec![0.0, 0.0, 0.0, 0.0, 2.0, 1.0]);
    let look = palette::TriangleColors::new(&mesh, &by);
    let [none, most] = [0, 1].map(|t| look.color(&mesh, t));
    assert!(none[2] > 1.5 * none[0] && most[0] > 1.5 * most[2]);
    let clipping = clip::Clipping::new(&mesh, &[], DVec3::X).unwrap();
    let lines = look.legend(&mesh, &clipping, [600, 400]).unwrap().lines;
    let texts: Vec<&str> = lines.iter().map(|l| l.1.as_str()).collect();
    assert_eq!(texts, ["distance", "2.00", "1.50", "1.00", "0.500", "0"]);
    let by = ColorBy::Distance(vec![f64::INFINITY, 0.0, 0.0, 0.0, 2e-7, 1e-7]);
    let look = palette::TriangleColors::new(&mesh, &by);
    let lines = look.legend(&mesh, &clipping, [600, 400]).unwrap().lines;
    assert_eq!((lines[1].1.as_str(), lines[6].1.as_str()), ("2.00e-7", "unknown"));
    assert_eq!(lines[6].0, Some(look.color(&mesh, 0)));
    let short = RenderOptions { color_by: ColorBy::Distance(vec![0.0; 5]), ..plain(50, DVec3::Z) };
    assert!(matches!(render(&mesh, &short, &Run::new()), Err(Error::Usage(_))));
}

#[test]
fn png_comes_back_as_it_was() {
    let p = render(&box_mesh(), &RenderOptions { width: 61, height: 47, ..Default::default() }, &Run::new()).unwrap();
    let bytes = p.png_bytes().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height, info.color_type), (61, 47, png::ColorType::Rgb));
    assert_eq!(pixels, p.rgb);
    assert!(Picture { width: 3, height: 3, rgb: vec![0; 5], alpha: None }.png_bytes().is_err());
}

#[test]
fn sheets_hold_every_cell_and_caption() {
    let cell = |c: f32| Picture::new(120, 50, [c, 0.0, 0.0]);
    let cells: Vec<_> = (0..5).map(|i| (format!("cell {i}"), cell(0.5 + 0.1 * i as f32))).collect();
    let p = sheet(&cells, 2);
    for (_, c) in &cells {
        assert_eq!(count(&p, |q| q == pixel(c, 0, 0)), 120 * 50);
    }
    assert!(count(&p, dark) > 5 * 5 * 20);
    assert_eq!(sheet(&[], 3).rgb.len(), 3);
    assert_eq!(sheet(&cells[..1], 0).width, p.width - 132);
}

#[test]
fn every_printable_character_has_a_shape_of_its_own() {
    let characters = (32..127u8).map(char::from).chain(['…']);
    let shapes: Vec<Vec<_>> = characters.map(|c| font::dots(c).collect()).collect();
    for (i, shape) in shapes.iter().enumerate() {
        assert_eq!(shape.is_empty(), i == 0);
        assert!(shape.iter().all(|(x, y)| *x < font::ADVANCE - 1 && *y < font::HEIGHT));
        assert!(shapes[..i].iter().all(|other| other != shape), "{i}");
    }
    assert!(font::dots('ß').eq(font::dots('?')));
}

#[test]
fn strange_meshes_and_options_are_refused_or_drawn() {
    let run = Run::new();
    let small = plain(20, DVec3::ONE);
    let refused = |mesh: &TriMesh, options: &RenderOptions| render(mesh, options, &run).is_err();
    assert!(refused(&TriMesh::default(), &small));
    assert!(refused(&box_mesh(), &RenderOptions { width: 0, ..small.clone() }));
    assert!(refused(&box_mesh(), &RenderOptions { samples: 9, ..small.clone() }));
    assert!(refused(&box_mesh(), &plain(20, DVec3::ZERO)));
    assert!(refused(&box_mesh(), &plain(20, DVec3::NAN)));
    let mut bad = box_mesh();
    bad.nodes[3].x = f64::NAN;
    assert!(refused(&bad, &small));
    let mut bad = box_mesh();
    bad.triangles[3][0] = 8;
    assert!(refused(&bad, &small));
    // Everything in one point, on a line across the view, and as large as numbers go.
    for f in [|_| DVec3::ONE, |p: DVec3| DVec3::splat(p.x), |p: DVec3| (2.0 * p - 1.0) * f64::MAX] {
        let mut mesh = box_mesh();
        mesh.nodes.iter_mut().for_each(|p| *p = f(*p));
        render(&mesh, &RenderOptions { sharp_angle: Some(30.0), ..small.clone() }, &run).unwrap();
    }
    let token = crate::run::CancelToken::new();
    token.cancel();
    assert!(matches!(render(&box_mesh(), &small, &Run::new().with_cancel(token)), Err(Error::Cancelled)));
}
