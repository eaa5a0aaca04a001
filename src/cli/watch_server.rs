//! The page of `watch` for browsers of this machine: four addresses, all from memory.
//!
//! It listens on 127.0.0.1 only, answers nothing but GET, and only to requests that name this machine as
//! their host, so that no page of somebody else's can read it through a name of its own.

use super::watch_desk::Desk;
use crate::files::InputError;
use crate::report::watch_page;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};
use tiny_http::{Header, Method, Request, Response, Server};

/// Ports that are tried after the one that was asked for.
const TRIES: u16 = 50;
/// How long a question for news waits, and how often it is looked whether there are any.
const PATIENCE: Duration = Duration::from_secs(20);
const TURN: Duration = Duration::from_millis(50);

/// What the page itself may load: nothing from elsewhere.
const OWN_ONLY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
    img-src 'self' data:; connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'";
/// The same for the report, whose plots make their pictures from data and their functions from text.
const REPORT_ONLY: &str = "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; \
    style-src 'unsafe-inline'; img-src data: blob:; font-src data:; base-uri 'none'; \
    form-action 'none'; frame-ancestors 'self'";

/// A browser that waits for news.
struct Waiting {
    request: Request,
    has: u64,
    until: Instant,
}

/// Serves the desk from a thread of its own as long as the program runs; the port.
///
/// # Errors
/// Where no port is free.
pub(super) fn serve(port: u16, desk: &Arc<Desk>) -> Result<u16, InputError> {
    let listener = listener(port)?;
    let failed = |e: String| InputError::fault("watch", format!("the page cannot be served: {e}"));
    let port = listener.local_addr().map_err(|e| failed(e.to_string()))?.port();
    let server = Server::from_listener(listener, None).map_err(|e| failed(e.to_string()))?;
    let desk = Arc::clone(desk);
    thread::spawn(move || {
        let mut waiting: Vec<Waiting> = Vec::new();
        loop {
            match server.recv_timeout(TURN) {
                Ok(Some(request)) => waiting.extend(take(request, port, &desk)),
                Ok(None) => {}
                // One connection broke; the next may not.
                Err(_) => thread::sleep(TURN),
            }
            let version = desk.version();
            let is_due = |w: &mut Waiting| w.has != version || w.until <= Instant::now();
            for due in waiting.extract_if(.., is_due) {
                answer(due.request, state(&desk));
            }
        }
    });
    Ok(port)
}

/// The port, or the next one that is free.
fn listener(port: u16) -> Result<TcpListener, InputError> {
    let last = if port == 0 { 0 } else { port.saturating_add(TRIES) };
    let mut why = String::new();
    for port in port..=last {
        match TcpListener::bind((Ipv4Addr::LOCALHOST, port)) {
            Ok(listener) => return Ok(listener),
            Err(e) => why = e.to_string(),
        }
    }
    Err(InputError::new("--port", format!("no port from {port} to {last} can be used: {why}"))
        .remedy("name another port, or 0 for any that is free"))
}

/// Answers a request; one for news that must wait is given back.
fn take(request: Request, port: u16, desk: &Desk) -> Option<Waiting> {
    let hosts: Vec<&str> = request
        .headers()
        .iter()
        .filter(|h| h.field.equiv("Host"))
        .map(|h| h.value.as_str())
        .collect();
    if !is_this_machine(&hosts, port) {
        answer(request, plain(403, "This page is only for browsers on this machine."));
        return None;
    }
    if *request.method() != Method::Get {
        answer(request, with(plain(405, "Only GET."), "Allow", "GET"));
        return None;
    }
    let url = request.url().to_owned();
    let (path, query) = url.split_once('?').unwrap_or((&url, ""));
    let made = match path {
        "/" => html(watch_page(&desk.scenario()).into_bytes(), OWN_ONLY),
        "/state" => {
            let has = query.strip_prefix("since=").and_then(|n| n.parse().ok()).unwrap_or(0);
            return Some(Waiting { request, has, until: Instant::now() + PATIENCE });
        }
        "/cell.png" => {
            desk.cell().map_or_else(missing, |png| typed(200, png.to_vec(), "image/png"))
        }
        "/report" => desk.report().map_or_else(missing, |page| html(page.to_vec(), REPORT_ONLY)),
        _ => missing(),
    };
    answer(request, made);
    None
}

/// Whether the one host that a request names is this machine, at this port.
fn is_this_machine(hosts: &[&str], port: u16) -> bool {
    let [host] = hosts else { return false };
    ["127.0.0.1", "localhost"].iter().any(|own| {
        let rest = host.get(..own.len()).filter(|h| h.eq_ignore_ascii_case(own));
        rest.is_some_and(|_| match &host[own.len()..] {
            "" => port == 80,
            other => other.strip_prefix(':').is_some_and(|p| p == port.to_string()),
        })
    })
}

type Made = Response<std::io::Cursor<Vec<u8>>>;

fn state(desk: &Desk) -> Made {
    typed(200, desk.status().to_string().into_bytes(), "application/json")
}

fn missing() -> Made {
    plain(404, "Not found.")
}

fn plain(code: u16, text: &str) -> Made {
    typed(code, format!("{text}\n").into_bytes(), "text/plain; charset=utf-8")
}

fn html(bytes: Vec<u8>, policy: &'static str) -> Made {
    with(typed(200, bytes, "text/html; charset=utf-8"), "Content-Security-Policy", policy)
}

fn typed(code: u16, bytes: Vec<u8>, kind: &'static str) -> Made {
    let headers = [
        ("Content-Type", kind),
        ("Cache-Control", "no-store"),
        ("X-Content-Type-Options", "nosniff"),
        ("Cross-Origin-Resource-Policy", "same-origin"),
        ("Referrer-Policy", "no-referrer"),
    ];
    let made = Response::from_data(bytes).with_status_code(code);
    headers.into_iter().fold(made, |made, (name, value)| with(made, name, value))
}

/// Adds a header; name and value are our own ASCII, which is always one.
fn with(made: Made, name: &'static str, value: &'static str) -> Made {
    match Header::from_bytes(name, value) {
        Ok(header) => made.with_header(header),
        Err(()) => made,
    }
}

/// Sends an answer from a thread of its own: a browser that reads slowly holds up nobody else.
fn answer(request: Request, made: Made) {
    thread::spawn(move || {
        // A browser that has gone needs no answer.
        let _ = request.respond(made);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_machine_at_this_port_is_answered() {
        for own in ["127.0.0.1:7350", "localhost:7350", "LocalHost:7350"] {
            assert!(is_this_machine(&[own], 7350), "{own}");
        }
        for other in [
            "",
            "127.0.0.1",
            "localhost",
            "127.0.0.1:7351",
            "127.0.0.1:07350",
            "127.0.0.1.example.org:7350",
            "localhost.example.org:7350",
            "example.org:7350",
            "example.org",
            "127.0.0.2:7350",
            "[::1]:7350",
            "localhöst:7350",
        ] {
            assert!(!is_this_machine(&[other], 7350), "{other}");
        }
        assert!(is_this_machine(&["localhost"], 80));
        assert!(!is_this_machine(&[], 7350));
        assert!(!is_this_machine(&["localhost:7350", "example.org"], 7350));
    }

    #[test]
    fn a_port_that_is_taken_is_passed_over() {
        let first = listener(0).unwrap();
        let port = first.local_addr().unwrap().port();
        if port < u16::MAX {
            let second = listener(port).unwrap().local_addr().unwrap();
            assert!(second.port() > port && second.ip().is_loopback());
        }
    }
}
