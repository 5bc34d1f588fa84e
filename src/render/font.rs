//! Letters as strokes on a small grid, drawn as thin antialiased lines at any size.

use super::picture::Picture;

/// Grid units from the bottom of a descender to the top of a capital.
const UNITS: f64 = 8.0;

/// Grid units from one letter to the next.
const ADVANCE: f64 = 6.0;

/// Strokes of a character: each word is a polyline of points, two digits each, x 0..4 and y 0..8 upward; the baseline is
/// y = 2.
fn strokes(c: char) -> &'static str {
    match c {
        'A' => "022842 1434",
        'B' => "020838474635053544433202",
        'C' => "4737170603123243",
        'D' => "02082846443202",
        'E' => "48080242 0535",
        'F' => "480802 0535",
        'G' => "473817060312324345 4525",
        'H' => "0208 4248 0545",
        'I' => "1232 2228 1838",
        'J' => "0312324348",
        'K' => "0208 4805 0542",
        'L' => "080242",
        'M' => "0208254842",
        'N' => "02084248",
        'O' => "1207081838474332120317",
        'P' => "02083847463505",
        'Q' => "12030718384743321203 2442",
        'R' => "02083847463505 2542",
        'S' => "4738180706153544433212 1203",
        'T' => "0848 2822",
        'U' => "080312324348",
        'V' => "082248",
        'W' => "0812253248",
        'X' => "0842 0248",
        'Y' => "082548 2522",
        'Z' => "08480242",
        'a' => "063645424203051545",
        'b' => "0802324345361605",
        'c' => "45361605031232",
        'd' => "4842120305164645",
        'e' => "04444536160503123243",
        'f' => "384827221622 0636",
        'g' => "4640301001 4605031242",
        'h' => "0802 0516364542",
        'i' => "1626 2622 2728",
        'j' => "26211000 2728",
        'k' => "0802 0436 1432",
        'l' => "18282332",
        'm' => "0206 051626 22252636 464236",
        'n' => "0206 0516364542",
        'o' => "1203051636454332120305",
        'p' => "0006364543321203",
        'q' => "4046160503124243",
        'r' => "0206 04162636",
        's' => "4616051444331202",
        't' => "28233242 0646",
        'u' => "060312324446 4642",
        'v' => "062246",
        'w' => "0612243246",
        'x' => "0642 0246",
        'y' => "0622 462000",
        'z' => "06460242",
        '0' => "120307183847433212 0347",
        '1' => "172822 1232",
        '2' => "071838474602 0242",
        '3' => "071838474635153544433212 1203",
        '4' => "38044432 3238",
        '5' => "480805354443321203",
        '6' => "47381807031232434435150404",
        '7' => "084812",
        '8' => "1506071838474635150403123243443515",
        '9' => "0312324347381807061545",
        '.' => "2223",
        ',' => "2310",
        ':' => "2223 2526",
        ';' => "2310 2526",
        '-' => "0545",
        '_' => "0141",
        '+' => "0545 2327",
        '/' => "0248",
        '(' => "38262422 2231",
        ')' => "18262422 2211",
        '[' => "38181131",
        ']' => "18383111",
        '%' => "0248 0717 3343",
        '=' => "0444 0646",
        '<' => "460542",
        '>' => "064502",
        '#' => "1228 3248 0646 0444",
        '*' => "0545 1327 3317",
        '|' => "2128",
        '~' => "0516253546",
        '!' => "2824 2223",
        '?' => "0718384746252423 2222",
        '&' => "420718280613223345",
        '@' => "33251423334547381807031242",
        '^' => "062846",
        '\'' => "2826",
        '"' => "1816 3836",
        ' ' => "",
        _ => "0208484202",
    }
}

/// Width of a text whose letters are `height` pixels from descender to capital.
pub(super) fn text_width(text: &str, height: f64) -> f64 {
    text.chars().count() as f64 * ADVANCE * height / UNITS
}

/// Draws a text; (`x`, `y`) is its top left corner, `height` pixels from descender to capital.
pub(super) fn text(picture: &mut Picture, text: &str, x: f64, y: f64, height: f64, color: [u8; 3]) {
    let unit = height / UNITS;
    for (i, c) in text.chars().enumerate() {
        let left = x + i as f64 * ADVANCE * unit;
        for word in strokes(c).split(' ') {
            let digits: Vec<f64> = word.bytes().map(|b| f64::from(b - b'0')).collect();
            let points: Vec<[f64; 2]> =
                digits.chunks_exact(2).map(|p| [left + p[0] * unit, y + (UNITS - p[1]) * unit]).collect();
            for pair in points.windows(2) {
                line(picture, pair[0], pair[1], (0.11 * height).max(1.0), color);
            }
        }
    }
}

/// Draws an antialiased line with round ends.
pub(super) fn line(picture: &mut Picture, a: [f64; 2], b: [f64; 2], width: f64, color: [u8; 3]) {
    let r = 0.5 * width;
    let bound = |i: usize| {
        let (lo, hi) = (a[i].min(b[i]) - r - 1.0, a[i].max(b[i]) + r + 1.0);
        (lo.floor().clamp(-1.0, 1e5) as i64, hi.ceil().clamp(-1.0, 1e5) as i64)
    };
    let ((x0, x1), (y0, y1)) = (bound(0), bound(1));
    let d = [b[0] - a[0], b[1] - a[1]];
    let length = d[0] * d[0] + d[1] * d[1];
    for y in y0..=y1 {
        for x in x0..=x1 {
            let p = [x as f64 + 0.5 - a[0], y as f64 + 0.5 - a[1]];
            let t = if length > 0.0 { ((p[0] * d[0] + p[1] * d[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
            let distance = (p[0] - t * d[0]).hypot(p[1] - t * d[1]);
            picture.mix(x, y, color, r + 0.5 - distance);
        }
    }
}
