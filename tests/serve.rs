//! `view --serve`: who is let in, what is served while a part is edited, and what an open page shows; `mesh --watch` of parts that
//! read files.
#![cfg(unix)]

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use approx::abs_diff_eq;
use rvachev::page::decode;
use serde_json::{Value, json};
use tempfile::TempDir;

/// What is waited for comes within this time on the slowest of machines.
const PATIENCE: Duration = Duration::from_secs(120);

/// Asks again and again until there is an answer.
fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        if let Some(found) = ask() {
            return found;
        }
        sleep(Duration::from_millis(50));
    }
    panic!("{what}: this does not come");
}

/// A block of a length along x, as wide and high as 1.
fn block(length: u32) -> String {
    format!("part(box(size=({length}, 1, 1)).name(\"block\"))\n")
}

/// The command at work on `part.py`, and what it told.
struct Served {
    folder: TempDir,
    child: Child,
    port: u16,
    token: String,
}

impl Served {
    fn new(part: &str) -> Self {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("part.py"), part).unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_rvachev"))
            .current_dir(&folder)
            .args(["view", "part.py", "--serve", "--size", "0.25", "-q"])
            .stdout(Stdio::piped())
            .stderr(File::create(folder.path().join("told")).unwrap())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (port, token) = line.trim().strip_prefix("http://127.0.0.1:").unwrap().split_once('/').unwrap();
        let token = token.strip_suffix('/').unwrap().to_string();
        Self { folder, child, port: port.parse().unwrap(), token }
    }

    fn write(&self, part: &str) {
        fs::write(self.folder.path().join("part.py"), part).unwrap();
    }

    /// What the terminal shows of errors.
    fn told(&self) -> String {
        fs::read_to_string(self.folder.path().join("told")).unwrap()
    }

    /// The whole answer to a request.
    fn ask(&self, request: &str) -> String {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    }

    fn get(&self, path: &str, host: &str) -> String {
        self.ask(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n"))
    }

    /// The answer to who knows all there is to know.
    fn open(&self, path: &str) -> String {
        let answer = self.get(&format!("/{}/{path}", self.token), &format!("127.0.0.1:{}", self.port));
        assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{path}: {answer:.200}");
        answer
    }

    fn state(&self) -> Value {
        serde_json::from_str(self.open("state").split_once("\r\n\r\n").unwrap().1).unwrap()
    }

    /// What the page is told besides the mesh.
    fn contents(&self) -> Value {
        let page = self.open("");
        let (_, after) = page.split_once("id=\"told\">").unwrap();
        serde_json::from_str(after.split_once("</script>").unwrap().0).unwrap()
    }

    fn wait_for_version(&self, version: u64) {
        wait_for("a version", || (self.state()["version"] == version).then_some(()));
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn only_who_knows_the_token_and_comes_to_this_machine_is_let_in() {
    let served = Served::new(&block(1));
    assert_eq!(served.token.len(), 32);
    let (here, token) = (format!("127.0.0.1:{}", served.port), served.token.clone());
    let mut other = token.clone().into_bytes();
    other[31] ^= 1;
    let other = String::from_utf8(other).unwrap();
    let page = served.open("");
    for header in
        ["Referrer-Policy: no-referrer", "Cache-Control: no-store", "Content-Security-Policy: default-src 'none'"]
    {
        assert!(page.contains(&format!("\r\n{header}")), "{header}");
    }
    assert!(served.get(&format!("/{token}/"), &format!("localhost:{}", served.port)).starts_with("HTTP/1.1 200"));
    for path in ["/", "/state", &format!("/{other}/"), &format!("/{other}/state"), &format!("/?{token}/")] {
        let answer = served.get(path, &here);
        assert!(answer.starts_with("HTTP/1.1 403 Forbidden\r\n"), "{path}: {answer:.200}");
        assert!(!answer.contains(&token) && !answer.contains("<script"), "{path}: {answer:.200}");
    }
    for host in ["evil.example", &format!("evil.example:{}", served.port), "127.0.0.1:1", ""] {
        for path in ["", "state"] {
            let answer = served.get(&format!("/{token}/{path}"), host);
            assert!(answer.starts_with("HTTP/1.1 403 Forbidden\r\n"), "{host}: {answer:.200}");
        }
    }
    assert!(served.get(&format!("/{token}/part.py"), &here).starts_with("HTTP/1.1 404"));
    let post = format!("POST /{token}/ HTTP/1.1\r\nHost: {here}\r\nContent-Length: 4\r\n\r\nabcd");
    assert!(served.ask(&post).starts_with("HTTP/1.1 405"));
    assert!(served.ask(&format!("GET /{}", "a".repeat(9000))).starts_with("HTTP/1.1 414"));
    // Clients that say nothing are not waited for by others, and learn that they took too long.
    let mut silent: Vec<_> = (0..8).map(|_| TcpStream::connect(("127.0.0.1", served.port)).unwrap()).collect();
    served.open("state");
    let mut text = String::new();
    silent[0].read_to_string(&mut text).unwrap();
    assert!(text.starts_with("HTTP/1.1 408"), "{text:.200}");
}

#[test]
fn what_is_served_follows_the_part() {
    let mut served = Served::new(&block(1));
    served.wait_for_version(1);
    let first = decode(&served.open("")).unwrap().triangles.len();
    assert_eq!(served.contents()["lo"], json!([-0.5, -0.5, -0.5]));
    served.write(&block(2));
    served.wait_for_version(2);
    let second = decode(&served.open("")).unwrap().triangles.len();
    assert!(first > 12 && second > first, "{first} and {second}");
    assert_eq!(served.contents()["lo"], json!([-1.0, -0.5, -0.5]));
    // A mistake is told in words that are no markup, and the picture stays.
    served.write("a = 1\npart(\"<script>alert(1)</script>\" \"</pre>\n");
    let state = wait_for("the mistake", || Some(served.state()).filter(|s| !s["trouble"].is_null()));
    let trouble = &state["trouble"];
    assert!(trouble["what"].as_str().is_some_and(|t| t.contains("part.py: line 2, column ")), "{trouble}");
    assert!(trouble["source"].as_str().is_some_and(|t| t.contains("<script>alert(1)</script>")), "{trouble}");
    assert_eq!(state["version"], 2);
    let raw = served.open("state");
    assert!(raw.contains("Content-Type: application/json\r\n") && raw.contains("X-Content-Type-Options: nosniff\r\n"));
    assert!(raw.contains("\\u003cscript>") && !raw.contains('<'), "{raw}");
    assert_eq!(decode(&served.open("")).unwrap().triangles.len(), second);
    wait_for("the mistake on the terminal", || served.told().contains("error: part.py: line 2, column ").then_some(()));
    // So is a part that cannot be meshed.
    served.write("part(sphere(1) - sphere(2))\n");
    wait_for("the empty part", || {
        let what = served.state()["trouble"]["what"].as_str().map(str::to_string);
        what.filter(|t| !t.contains("line 2"))
    });
    assert_eq!(served.state()["version"], 2);
    served.write(&block(3));
    served.wait_for_version(3);
    assert_eq!(served.state(), json!({"version": 3, "meshing": false, "trouble": null}));
    assert_eq!(served.contents()["lo"], json!([-1.5, -0.5, -0.5]));
    // Nothing is written beside the part.
    assert_eq!(fs::read_dir(&served.folder).unwrap().count(), 2);
    let killed = Command::new("kill").args(["-INT", &served.child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    assert_eq!(served.child.wait().unwrap().code(), Some(130));
}

/// A closed box from a corner to (1, 1, 1), in a file of triangles.
fn write_box(path: &Path, from: [f64; 3]) {
    let corner = |k: usize| [0, 1, 2].map(|i| if k >> i & 1 == 1 { 1.0 } else { from[i] });
    let mut text = String::from("OFF\n8 12 0\n");
    for k in 0..8 {
        let [x, y, z] = corner(k);
        text.push_str(&format!("{x} {y} {z}\n"));
    }
    for [a, b, c, d] in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
        text.push_str(&format!("3 {a} {b} {c}\n3 {a} {c} {d}\n"));
    }
    fs::write(path, text).unwrap();
}

#[test]
fn what_is_served_follows_the_files_the_part_reads() {
    let served = Served::new("part(mesh(\"lump.off\") - box(lo=(9, 9, 9), hi=(10, 10, 10)))\n");
    let lump = served.folder.path().join("lump.off");
    // A file that is not there is told, and its coming is enough.
    let trouble = |what: &str| {
        wait_for(what, || served.state()["trouble"]["what"].as_str().filter(|t| t.contains(what)).map(str::to_string))
    };
    trouble("lump.off");
    write_box(&lump, [0.0, 0.0, 0.0]);
    served.wait_for_version(1);
    assert_eq!(served.contents()["lo"], json!([0.0, 0.0, 0.0]));
    write_box(&lump, [0.0, 0.0, -1.0]);
    served.wait_for_version(2);
    assert_eq!(served.contents()["lo"], json!([0.0, 0.0, -1.0]));
    // Once the part reads another file that one counts, and the old one does not.
    write_box(&served.folder.path().join("other.off"), [0.0, 0.0, -2.0]);
    served.write("part(mesh(\"other.off\") - box(lo=(9, 9, 9), hi=(10, 10, 10)))\n");
    served.wait_for_version(3);
    fs::remove_file(&lump).unwrap();
    write_box(&served.folder.path().join("other.off"), [0.0, 0.0, -1.5]);
    served.wait_for_version(4);
    assert_eq!(served.contents()["lo"], json!([0.0, 0.0, -1.5]));
}

/// A command that is killed at the end of a test, however that comes.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_watched_mesh_follows_the_files_the_part_reads() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let model = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("data/step").join(name);
    write_box(&at("lump.off"), [0.0, 0.0, 0.0]);
    fs::copy(model("sphere.step"), at("model.step")).unwrap();
    let part = "part(mesh(\"lump.off\") | step(\"model.step\").move((10, 0, 0)))\n";
    fs::write(at("part.py"), part).unwrap();
    let arguments = ["mesh", "part.py", "-o", "out.off", "--size", "0.5", "--watch", "-q"];
    let told = File::create(at("told")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_rvachev"));
    let _killed = Killed(command.current_dir(&folder).args(arguments).stderr(told).spawn().unwrap());
    // The lowest corner of the lump, and of the model beside it.
    let lowest = || {
        let mesh = rvachev::io::read(&at("out.off"), &rvachev::Run::new()).ok()?;
        let of = |side: bool| mesh.nodes.iter().filter(|p| (p.x > 5.0) == side).map(|p| p.z).fold(0.0, f64::min);
        Some([of(false), of(true)])
    };
    // A ball of radius 2, and a ring that is as thick.
    let comes = |what: &str, lump: f64, model: f64| {
        wait_for(what, || lowest().filter(|z| z[0] == lump && (z[1] - model).abs() < 0.05));
    };
    comes("the first mesh", 0.0, -2.0);
    write_box(&at("lump.off"), [0.0, 0.0, -1.0]);
    comes("the new lump", -1.0, -2.0);
    fs::copy(model("torus.step"), at("model.step")).unwrap();
    comes("the new model", -1.0, -1.0);
}

#[test]
fn what_cannot_be_served_is_refused() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("part.py"), block(1)).unwrap();
    let code = |args: &[&str]| {
        let out =
            Command::new(env!("CARGO_BIN_EXE_rvachev")).current_dir(&folder).arg("view").args(args).output().unwrap();
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "{args:?}");
        out.status.code()
    };
    for port in ["0", "65536", "-1", "http", ""] {
        assert_eq!(code(&["part.py", "--serve", &format!("--port={port}")]), Some(2), "{port}");
    }
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    assert_eq!(code(&["part.py", "--serve", "--port", &port]), Some(2));
    assert_eq!(code(&["part.py", "--port", "8000"]), Some(2));
    assert_eq!(code(&["part.py", "--serve", "-o", "a.html"]), Some(2));
    assert_eq!(code(&["none.py", "--serve"]), Some(3));
}

#[test]
fn a_page_on_its_own_asks_nobody() {
    let served = Served::new(&block(1));
    served.wait_for_version(1);
    let to = served.folder.path().join("a.html");
    let made = Command::new(env!("CARGO_BIN_EXE_rvachev"))
        .current_dir(&served.folder)
        .args(["view", "part.py", "--size", "0.25", "-q", "-o", "a.html"])
        .status()
        .unwrap();
    assert!(made.success());
    let (alone, follows) = (fs::read_to_string(to).unwrap(), served.open(""));
    for mark in ["connect-src", "fetch(", "location.reload"] {
        assert!(!alone.contains(mark) && follows.contains(mark), "{mark}");
    }
    assert_eq!(decode(&alone).unwrap().triangles, decode(&follows).unwrap().triangles);
}

/// A browser that is asked through two pipes: messages are JSON and end in a zero byte.
struct Browser {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    session: Value,
    asked: u64,
    _home: TempDir,
}

impl Browser {
    fn new(address: &str) -> Self {
        let home = TempDir::new().unwrap();
        // It is asked at handle 3 and answers at handle 4.
        let mut child = Command::new("sh")
            .args(["-c", "exec chromium \"$@\" 3<&0 4>&1 </dev/null >/dev/null", "chromium"])
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader"])
            .args(["--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run", "--disable-sync"])
            .args(["--disable-background-networking", "--disable-component-update", "--window-size=900,600"])
            .arg("--remote-debugging-pipe")
            .arg(format!("--user-data-dir={}", home.path().display()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let (to, from) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
        let mut browser = Self { child, to, from, session: Value::Null, asked: 0, _home: home };
        let target = browser.call("Target.createTarget", json!({"url": address}));
        let target = json!({"targetId": target["result"]["targetId"], "flatten": true});
        browser.session = browser.call("Target.attachToTarget", target)["result"]["sessionId"].take();
        browser
    }

    fn call(&mut self, method: &str, params: Value) -> Value {
        self.asked += 1;
        let mut message = json!({"id": self.asked, "method": method, "params": params});
        if self.session.is_string() {
            message["sessionId"] = self.session.clone();
        }
        self.to.write_all(format!("{message}\0").as_bytes()).unwrap();
        loop {
            let mut bytes = Vec::new();
            self.from.read_until(0, &mut bytes).unwrap();
            bytes.pop();
            let answer: Value =
                serde_json::from_slice(&bytes).expect("this test needs a browser: `apt-get install -y chromium`");
            if answer["id"] == self.asked {
                return answer;
            }
        }
    }

    /// The value of an expression in the page; nothing while the page is being loaded.
    fn value(&mut self, expression: &str) -> Option<Value> {
        let mut answer = self.call("Runtime.evaluate", json!({"expression": expression, "returnByValue": true}));
        let value = answer["result"]["result"]["value"].take();
        (answer["error"].is_null() && answer["result"]["exceptionDetails"].is_null()).then_some(value)
    }

    fn wait_for(&mut self, what: &str) {
        wait_for(what, || self.value(what).filter(|v| *v == true));
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn an_open_page_shows_the_new_part_and_keeps_what_was_chosen() {
    // The page is open before there is anything to show.
    let served = Served::new("part(box(\n");
    let mut browser = Browser::new(&format!("http://127.0.0.1:{}/{}/", served.port, served.token));
    browser.wait_for("banner.textContent.includes('part.py: line ')");
    served.write(&block(1));
    let ready =
        |version: u64| format!("VERSION === {version} && scene !== undefined && !!state && banner.textContent === ''");
    browser.wait_for(&ready(1));
    assert_eq!(browser.value("told.lo").unwrap(), json!([-0.5, -0.5, -0.5]));
    let choose = "camera.yaw = 1.25; camera.pitch = 0.3; camera.target = mesh.drawn([0.1, 0.2, 0.3]); camera.reach = 1.5 / mesh.unit;
        $('faces').querySelector('input').click(); $('wire').click(); $('axis').value = '1'; cut(); theme(true);
        $('color').value = 'angle'; colorBy('angle'); told.faces.filter((_, f) => !shown[f]).map((f) => f.name)";
    let hidden = browser.value(choose).unwrap();
    assert_eq!(hidden.as_array().map(Vec::len), Some(1));
    served.write(&block(3));
    browser.wait_for(&ready(2));
    assert_eq!(browser.value("told.lo").unwrap(), json!([-1.5, -0.5, -0.5]));
    let shown = "told.faces.filter((_, f) => !shown[f]).map((f) => f.name)";
    assert_eq!(browser.value(shown).unwrap(), hidden);
    let chosen =
        "[$('wire').checked && state.wire, $('faces').querySelector('input').checked, $('axis').value, state.cutting,
        $('color').value, state.mode === MODE.value, document.documentElement.dataset.theme]";
    assert_eq!(browser.value(chosen).unwrap(), json!([true, false, "1", true, "angle", true, "dark"]));
    let camera =
        browser.value("[camera.yaw, camera.pitch, ...mesh.told(camera.target), camera.reach * mesh.unit]").unwrap();
    let camera: Vec<f64> = serde_json::from_value(camera).unwrap();
    for (is, was) in camera.iter().zip([1.25, 0.3, 0.1, 0.2, 0.3, 1.5]) {
        assert!(abs_diff_eq!(*is, was, epsilon = 1e-9), "{camera:?}");
    }
    // Of a block that a camera looks at some pixels are drawn; after a mistake as many as before.
    let pixels = "draw(), scene.count((r, g, b, a) => a > 0)";
    let drawn = browser.value(pixels).unwrap().as_f64().unwrap();
    assert!(drawn > 1000.0, "{drawn}");
    served.write("part(\n  \"<script>document.title = 'hurt'</script><img src=x>\n");
    browser.wait_for("!banner.hidden && banner.textContent.includes('part.py: line 2')");
    let text = browser.value("banner.textContent").unwrap();
    assert!(text.as_str().unwrap().contains("<script>document.title = 'hurt'</script><img src=x>"), "{text}");
    let harmless = "[banner.childElementCount, document.title, VERSION]";
    assert_eq!(browser.value(harmless).unwrap(), json!([0, "part.py", 2]));
    assert_eq!(browser.value(pixels).unwrap().as_f64(), Some(drawn));
    drop(served);
    browser.wait_for("banner.textContent.startsWith('Nobody answers')");
}
