//! What pictures must show, read off their pixels.

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
    let grey = |c: [u8; 3]| c[0].abs_diff(c[1]) < 20 && c[1].abs_diff(c[2]) < 6 && (60..160).contains(&c[0]);
    assert!(count(&open, grey) > 10 * count(&closed, grey).max(100));
}

#[test]
fn touching_faces_differ_and_equal_names_agree() {
    let mesh = box_mesh();
    let look = palette::Look::new(&mesh, &ColorBy::Face);
    let colors: Vec<_> = (0..12).step_by(2).map(|t| look.color(&mesh, t)).collect();
    for i in 0..6 {
        assert!((0..i).all(|j| colors[i] != colors[j]));
    }
    // The same names in another order keep their colors.
    let mut turned = box_mesh();
    turned.faces.rotate_left(2);
    turned.labels.iter_mut().for_each(|l| *l = (*l + 4) % 6);
    let look = palette::Look::new(&turned, &ColorBy::Face);
    assert!((0..6).all(|i| look.color(&turned, 2 * i) == colors[i]));
}

#[test]
fn quality_goes_from_red_to_blue() {
    let nodes = vec![DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.75f64.sqrt(), 0.0), DVec3::new(0.5, 0.01, 0.0)];
    let mesh = TriMesh::new(nodes, vec![[0, 1, 2], [0, 1, 3], [0, 1, 1]]);
    let look = palette::Look::new(&mesh, &ColorBy::Angle);
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
    let shapes: Vec<Vec<_>> = (32..127u8).map(|c| font::dots(c as char).collect()).collect();
    for (i, shape) in shapes.iter().enumerate() {
        assert_eq!(shape.is_empty(), i == 0);
        assert!(shape.iter().all(|(x, y)| *x < font::ADVANCE - 1 && *y < font::HEIGHT));
        assert!(shapes[..i].iter().all(|other| other != shape), "{}", (32 + i as u8) as char);
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
