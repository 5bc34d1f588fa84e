//! The little of HTTP that a page for one person needs: GET on the loopback address, one answer to a connection.
//!
//! Other programs and other pages in the browser reach the same port. The path begins with a token they cannot guess, and the host
//! has to be the loopback one: a foreign name that is made to lead here is refused. What a client sends, and how long it takes to
//! send and to read, is bounded.

use std::hint::black_box;
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use rvachev::{Error, Result};

/// Bytes of a request's first line: as many as common servers take.
const LONGEST_LINE: usize = 8 << 10;
/// Bytes of all its lines.
const LONGEST_HEAD: usize = 16 << 10;

/// Lines behind the first one.
const MOST_HEADERS: usize = 64;

/// Connections at a time; more are closed at once.
const MOST_CONNECTIONS: usize = 64;

/// How long a client may take to ask.
const ASKING: Duration = Duration::from_secs(5);
/// How long a client may take to read the answer: a page may have many megabytes.
const READING: Duration = Duration::from_secs(60);

/// How long what a client still sends is thrown away: to close at once would take the answer from it.
const LEAVING: Duration = Duration::from_millis(500);

/// Random bytes of the token.
const TOKEN: usize = 16;

/// Fits the page: it has its scripts, styles and one empty picture within itself, and asks this server for its state.
const HEADERS: &str = "Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
     img-src data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
     Referrer-Policy: no-referrer\r\n\
     Cache-Control: no-store\r\n\
     X-Content-Type-Options: nosniff\r\n\
     Cross-Origin-Opener-Policy: same-origin\r\n\
     Cross-Origin-Resource-Policy: same-origin\r\n\
     Connection: close\r\n";

/// What a path leads to.
pub struct HttpContent {
    /// Its MIME type.
    pub kind: &'static str,
    pub body: Arc<str>,
}

/// A port of the loopback address, and what has to be known to come in.
pub struct Doorway {
    listener: TcpListener,
    keys: Keys,
}

/// What a request has to tell.
struct Keys {
    port: u16,
    token: String,
}

impl Doorway {
    /// Takes a port, a free one if none is asked for. Errors: [`Error::Usage`] for a port that cannot be had.
    pub fn new(port: Option<u16>) -> Result<Self> {
        let failed = |e: io::Error| match port {
            Some(n) => Error::Usage(format!("--port {n} cannot be had: {e}")),
            None => Error::Failed(format!("cannot listen on the loopback address: {e}")),
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port.unwrap_or(0))).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        let mut bytes = [0; TOKEN];
        getrandom::fill(&mut bytes).map_err(|e| Error::Failed(format!("the system gives no random numbers: {e}")))?;
        let token = bytes.iter().map(|b| format!("{b:02x}")).collect();
        Ok(Self { listener, keys: Keys { port, token } })
    }

    /// The address a browser opens.
    pub fn address(&self) -> String {
        format!("http://{}:{}/{}/", Ipv4Addr::LOCALHOST, self.keys.port, self.keys.token)
    }

    /// Answers until the process ends. `content` is asked with the path behind the token, and has nothing for those that do not exist.
    pub fn open(self, content: impl Fn(&str) -> Option<HttpContent> + Send + Sync + 'static) -> Result<()> {
        let Self { listener, keys } = self;
        let shared = Arc::new((keys, content));
        let accept = move || {
            let seats = Arc::new(());
            for stream in listener.incoming() {
                let Ok(stream) = stream else {
                    // The system has no more handles, say.
                    thread::sleep(LEAVING);
                    continue;
                };
                if Arc::strong_count(&seats) > MOST_CONNECTIONS {
                    continue;
                }
                let (shared, seat) = (Arc::clone(&shared), Arc::clone(&seats));
                let talk = move || {
                    // A client that went away needs no answer.
                    let _ = answer(&stream, &shared.0, &shared.1);
                    drop(seat);
                };
                // Without a thread the connection is closed.
                let _ = thread::Builder::new().name("connection".into()).spawn(talk);
            }
        };
        let started = thread::Builder::new().name("server".into()).spawn(accept);
        started.map(drop).map_err(|e| Error::Failed(format!("cannot start a thread: {e}")))
    }
}

/// A connection that ends at a time, however often something comes.
struct Limited<'a> {
    stream: &'a TcpStream,
    end: Instant,
}

impl<'a> Limited<'a> {
    fn new(stream: &'a TcpStream, time: Duration) -> Self {
        Self { stream, end: Instant::now() + time }
    }

    /// The time left, which is never nothing.
    fn left(&self) -> io::Result<Option<Duration>> {
        let left = self.end.saturating_duration_since(Instant::now());
        if left.is_zero() { Err(io::ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }
}

impl Read for Limited<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        self.stream.read(bytes)
    }
}

impl Write for Limited<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

/// What stands on the first line of an answer.
type Status = &'static str;

/// Reads a request and answers it.
fn answer(stream: &TcpStream, keys: &Keys, content: &impl Fn(&str) -> Option<HttpContent>) -> io::Result<()> {
    let mut status = "200 OK";
    let found = match asked(stream, keys)? {
        Ok(path) => content(&path).ok_or("404 Not Found"),
        Err(refused) => Err(refused),
    };
    let content = found.unwrap_or_else(|refused| {
        status = refused;
        HttpContent { kind: "text/plain; charset=utf-8", body: format!("{refused}\n").into() }
    });
    let HttpContent { kind, body } = content;
    let allow = if status.starts_with("405") { "Allow: GET\r\n" } else { "" };
    let head =
        format!("HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n{allow}{HEADERS}\r\n", body.len());
    let mut out = Limited::new(stream, READING);
    out.write_all(head.as_bytes())?;
    out.write_all(body.as_bytes())?;
    stream.shutdown(Shutdown::Write)?;
    io::copy(&mut Limited::new(stream, LEAVING), &mut io::sink()).map(drop)
}

/// Reads a request to the end of its head: the path behind the token, or why it is refused.
fn asked(stream: &TcpStream, keys: &Keys) -> io::Result<std::result::Result<String, Status>> {
    let mut from = Limited::new(stream, ASKING);
    let mut head = Vec::new();
    let mut some = [0; 2048];
    loop {
        match from.read(&mut some) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(n) => head.extend_from_slice(&some[..n]),
            Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
            Err(e) if matches!(e.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock) => {
                return Ok(Err("408 Request Timeout"));
            }
            Err(e) => return Err(e),
        }
        if let Some(known) = judged(&head, keys) {
            return Ok(known);
        }
    }
}

/// What comes of the bytes so far: nothing while more have to come, else the path behind the token, or why it is refused.
fn judged(head: &[u8], keys: &Keys) -> Option<std::result::Result<String, Status>> {
    if head.iter().take(LONGEST_LINE + 1).all(|b| *b != b'\n') && head.len() > LONGEST_LINE {
        return Some(Err("414 URI Too Long"));
    }
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(head) {
        Ok(httparse::Status::Complete(_)) => {}
        Ok(httparse::Status::Partial) if head.len() <= LONGEST_HEAD => return None,
        Ok(httparse::Status::Partial) | Err(httparse::Error::TooManyHeaders) => {
            return Some(Err("431 Request Header Fields Too Large"));
        }
        Err(_) => return Some(Err("400 Bad Request")),
    }
    let mut hosts = request.headers.iter().filter(|h| h.name.eq_ignore_ascii_case("host")).map(|h| h.value);
    let is_here = hosts.next().is_some_and(|h| keys.is_host(h)) && hosts.next().is_none();
    let path = request.path.and_then(|p| keys.unlocked(p));
    Some(match path {
        Some(path) if is_here && request.method == Some("GET") => Ok(path.to_string()),
        Some(_) if is_here => Err("405 Method Not Allowed"),
        _ => Err("403 Forbidden"),
    })
}

impl Keys {
    /// Whether a host, with its port, is this one.
    fn is_host(&self, host: &[u8]) -> bool {
        let named = |name: &str| {
            let with_port = format!("{name}:{}", self.port);
            host.eq_ignore_ascii_case(with_port.as_bytes())
                || (self.port == 80 && host.eq_ignore_ascii_case(name.as_bytes()))
        };
        named("localhost") || named("127.0.0.1")
    }

    /// The path behind the token, without a query; nothing where the token is another.
    fn unlocked<'p>(&self, target: &'p str) -> Option<&'p str> {
        let path = target.split('?').next().unwrap_or_default();
        let (token, rest) = path.strip_prefix('/')?.split_once('/')?;
        same(token.as_bytes(), self.token.as_bytes()).then_some(rest)
    }
}

/// Whether two texts are the same. For texts of one length the time tells nothing of where they differ.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && black_box(a.iter().zip(b).fold(0, |all, (x, y)| black_box(all | (x ^ y)))) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys() -> Keys {
        Keys { port: 8000, token: "0123456789abcdef".into() }
    }

    fn judge(head: &str) -> Option<std::result::Result<String, Status>> {
        judged(head.as_bytes(), &keys())
    }

    #[test]
    fn who_knows_the_token_and_comes_to_this_host_is_let_in() {
        for host in ["127.0.0.1:8000", "localhost:8000", "LocalHost:8000"] {
            for (target, path) in [("", ""), ("state", "state"), ("state?a=1", "state"), ("../x", "../x")] {
                let head = format!("GET /0123456789abcdef/{target} HTTP/1.1\r\nAccept: */*\r\nhost: {host}\r\n\r\n");
                assert_eq!(judge(&head), Some(Ok(path.into())), "{head}");
                // Every piece of it has to wait for the rest.
                for end in 0..head.len() {
                    assert_eq!(judge(&head[..end]), None, "{:?}", &head[..end]);
                }
            }
        }
    }

    #[test]
    fn others_are_refused() {
        let here = "Host: 127.0.0.1:8000\r\n";
        let long = "a".repeat(LONGEST_LINE);
        let many = "a: b\r\n".repeat(MOST_HEADERS + 1);
        let wide = format!("a: {}\r\n", "b".repeat(LONGEST_HEAD));
        let ask = |line: &str, headers: &str| judge(&format!("{line} HTTP/1.1\r\n{headers}\r\n"));
        let good = "GET /0123456789abcdef/";
        for (line, headers, status) in [
            ("GET /", here, "403"),
            ("GET /0123456789abcdef", here, "403"),
            ("GET /0123456789abcdee/", here, "403"),
            ("GET /0123456789abcde/", here, "403"),
            ("GET //0123456789abcdef/", here, "403"),
            ("GET http://127.0.0.1:8000/0123456789abcdef/", here, "403"),
            ("POST /", here, "403"),
            (good, "", "403"),
            (good, "Host: evil.example:8000\r\n", "403"),
            (good, "Host: 127.0.0.1\r\n", "403"),
            (good, "Host: 127.0.0.1:80\r\n", "403"),
            (good, "Host: 127.0.0.1.evil.example:8000\r\n", "403"),
            (good, "Host: 127.0.0.1:8000\r\nHost: evil.example\r\n", "403"),
            ("POST /0123456789abcdef/", here, "405"),
            ("HEAD /0123456789abcdef/", here, "405"),
            ("GET  /0123456789abcdef/", here, "400"),
            (good, "Host 127.0.0.1:8000\r\n", "400"),
            (format!("GET /{long}").as_str(), here, "414"),
            (good, many.as_str(), "431"),
        ] {
            let told = ask(line, headers);
            let refused = matches!(&told, Some(Err(s)) if s.starts_with(status));
            assert!(refused, "{line} with {headers:?} is {told:?}");
        }
        // What has no end is not waited for.
        assert_eq!(judge(&format!("{good} HTTP/1.1\r\n{wide}")), Some(Err("431 Request Header Fields Too Large")));
        assert_eq!(judge(&long), None);
        assert_eq!(judge(&format!("{long}a")), Some(Err("414 URI Too Long")));
    }
}
