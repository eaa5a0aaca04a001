//! Valid files changed in ways that files go wrong, the same each time.

use super::seeds::Kind;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A changed file, and what was done to it.
pub(super) struct Mutant {
    pub what: String,
    pub bytes: Vec<u8>,
}

const DEEP: usize = 100_000;
const LONG: usize = 1 << 20;

/// Numbers that programs stumble over.
const NUMBERS: [&str; 24] = [
    "nan",
    "NaN",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-320",
    "1e999",
    "-1",
    "0",
    "-0",
    "0.0",
    "1",
    "0x10",
    "1_0",
    "",
    "1,5",
    "1e9",
    "2147483648",
    "4294967296",
    "18446744073709551615",
    "9223372036854775808",
    "99999999999999999999999",
    "-9223372036854775809",
];

/// Words that are no names.
const WORDS: [&str; 14] = [
    "",
    " ",
    "..",
    "../../etc/passwd",
    "/dev/zero",
    "/",
    ".",
    "\u{0}",
    "<script>alert(1)</script>",
    "=cmd|' /C calc'!A0",
    "\u{202e}\u{feff}",
    "é\u{301}",
    "%s%n",
    "*",
];

/// Changes of the whole file, for the first seed of a kind.
pub(super) fn whole(kind: Kind, seed: &[u8]) -> Vec<Mutant> {
    let mut all: Vec<Mutant> = Vec::new();
    let mut add = |what: &str, bytes: Vec<u8>| all.push(Mutant { what: what.to_owned(), bytes });
    add("empty", Vec::new());
    add("a zero byte", vec![0]);
    add("zero bytes", vec![0; 4096]);
    add("all bytes 255", vec![255; 4096]);
    add("a byte order mark before it", [b"\xEF\xBB\xBF", seed].concat());
    add("twice", [seed, seed].concat());
    add("Windows line ends", replaced(seed, b"\n", b"\r\n"));
    add("old Macintosh line ends", replaced(seed, b"\n", b"\r"));
    add("UTF-16", [0xFF, 0xFE].into_iter().chain(seed.iter().flat_map(|b| [*b, 0])).collect());
    add("a long line before it", [&vec![b'a'; LONG], &b"\n"[..], seed].concat());
    add("a long line after it", [seed, &vec![b'7'; LONG]].concat());
    add("many empty lines after it", [seed, &vec![b'\n'; LONG]].concat());
    add("no end of the last line", seed.trim_ascii_end().to_vec());
    all.extend(of_kind(kind, seed));
    all
}

/// Changes that only this kind of file has.
fn of_kind(kind: Kind, seed: &[u8]) -> Vec<Mutant> {
    let mut all: Vec<Mutant> = Vec::new();
    let mut add = |what: &str, bytes: Vec<u8>| all.push(Mutant { what: what.to_owned(), bytes });
    let nested = |open: &str, middle: &str, close: &str| {
        (open.repeat(DEEP) + middle + &close.repeat(DEEP)).into_bytes()
    };
    let within = |open: &str, middle: &str, close: &str, before: &str| {
        [before.as_bytes(), &nested(open, middle, close)].concat()
    };
    match kind {
        Kind::Toml => {
            add("deep lists", within("[", "", "]", "name = "));
            add("deep tables", within("{a=", "1", "}", "name = "));
            add("a deep key", within("a.", "a = 1\n", "", ""));
            add("many tables", "[[obstacle]]\n".repeat(20_000).into_bytes());
        }
        Kind::Json => {
            add("deep lists", nested("[", "", "]"));
            add("deep objects", nested("{\"a\":", "1", "}"));
            add("deep messages", nested("{\"trajectory\":", "1", "}"));
            add("deep lists of messages", nested("{\"trajectory\":[", "1", "]}"));
            add("a list in its place", b"[]".to_vec());
            add("null in its place", b"null".to_vec());
        }
        Kind::Yaml => {
            add("deep lists", nested("[", "", "]"));
            add("deep maps", nested("{a: ", "1", "}"));
            add("deep messages", nested("{trajectory: ", "1", "}"));
            let steps = (0..2000).map(|i| format!("{}trajectory:\n", " ".repeat(i)));
            add("deep indents", steps.collect::<String>().into_bytes());
            let bomb = (1..12).map(|i| {
                format!("a{i}: &a{i} [{}]\n", vec![format!("*a{}", i - 1); 10].join(", "))
            });
            add(
                "a bomb of anchors",
                ("a0: &a0 [x]\n".to_owned() + &bomb.collect::<String>()).into_bytes(),
            );
        }
        Kind::Xml => {
            add("deep elements", nested("<a>", "", "</a>"));
            add("deep elements without end", nested("<node id=\"a\">", "", ""));
            for mutant in of_xml(seed) {
                add(&mutant.what, mutant.bytes);
            }
        }
        Kind::Text => {
            add("deep braces", nested("JOINT a\n{\nOFFSET 0 0 0\n", "", "}\n"));
            let hierarchy = "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 0\n";
            add(
                "deep joints",
                within("JOINT a\n{\nOFFSET 0 0 0\nCHANNELS 0\n", "", "}\n", hierarchy),
            );
            add("a bone of itself", replaced(seed, b"root lhipjoint", b"lfemur lhipjoint"));
            add("many bounds", "rank == 1 and ".repeat(20_000).into_bytes());
            add("many faces", [seed, "f 1 2 3\n".repeat(100_000).as_bytes()].concat());
            add("a face of many corners", [seed, b"f", " 1".repeat(100_000).as_bytes()].concat());
        }
        Kind::Table => {
            add("many columns", "a,".repeat(100_000).into_bytes());
            add("many columns of a row", [seed, "1,".repeat(100_000).as_bytes()].concat());
            add("an open quote", [seed, b"\"", &vec![b'x'; LONG]].concat());
            let last = seed.trim_ascii_end().rsplit(|b| *b == b'\n').next().unwrap_or_default();
            let rows = [last, b"\n"].concat().repeat(2000);
            add("many equal rows", [seed.trim_ascii_end(), b"\n", &rows].concat());
            let header: Vec<&[u8]> = seed.split_inclusive(|b| *b == b'\n').collect();
            add("one row", header[..header.len().min(2)].concat());
        }
        Kind::Binary => {
            for at in [4, 8, 12, 80, 81, 82, 83] {
                let mut bytes = seed.to_vec();
                if let Some(b) = bytes.get_mut(at) {
                    *b = 255;
                }
                add(&format!("byte {at} is 255"), bytes);
            }
        }
    }
    all
}

/// Entities, attributes, and elements within themselves.
fn of_xml(seed: &[u8]) -> Vec<Mutant> {
    let mut all: Vec<Mutant> = Vec::new();
    let mut add = |what: &str, bytes: Vec<u8>| all.push(Mutant { what: what.to_owned(), bytes });
    let text = String::from_utf8_lossy(seed);
    let root = text.find("?>").map_or(0, |at| at + 2);
    let entity = |i: usize| format!("<!ENTITY a{i} \"{}\">", format!("&a{};", i - 1).repeat(10));
    let entities = (1..12).map(entity).collect::<Vec<_>>().concat();
    for (what, more) in [("a bomb of entities", "&a11;"), ("an entity", "&a0;")] {
        let head = format!("<!DOCTYPE a [<!ENTITY a0 \"x\">{entities}]>");
        let used = text[root..].replacen('>', &format!(">{more}"), 1);
        add(what, (text[..root].to_owned() + &head + &used).into_bytes());
    }
    let named = "<!DOCTYPE a [<!ENTITY a SYSTEM \"file:///etc/passwd\">]>";
    let used = text[root..].replacen('>', ">&a;", 1);
    add("an entity of a file", (text[..root].to_owned() + named + &used).into_bytes());
    let many = (0..20_000).map(|i| format!(" a{i}=\"\"")).collect::<Vec<_>>().concat();
    add("many attributes", text.replacen('>', &format!("{many}>"), 2).into_bytes());
    add("a cycle", text.replace("<child link=\"l2\"/>", "<child link=\"base\"/>").into_bytes());
    add(
        "a node in itself",
        text.replace(
            "url=\"#g\"/></node></library",
            "url=\"#g\"/><instance_node url=\"#part\"/></node></library",
        )
        .into_bytes(),
    );
    all
}

fn replaced(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        if bytes[at..].starts_with(from) {
            out.extend(to);
            at += from.len();
        } else {
            out.push(bytes[at]);
            at += 1;
        }
    }
    out
}

/// One or more small changes somewhere.
pub(super) fn some(kind: Kind, seed: &[u8], rng: &mut ChaCha8Rng) -> Mutant {
    let mut mutant = Mutant { what: String::new(), bytes: seed.to_vec() };
    // Mostly one change: of several the first is refused.
    let count = if rng.random_bool(0.75) { 1 } else { rng.random_range(2..5) };
    for _ in 0..count {
        let (what, bytes) = change(kind, &mutant.bytes, rng);
        mutant.what =
            if mutant.what.is_empty() { what } else { format!("{}, {what}", mutant.what) };
        mutant.bytes = bytes;
    }
    mutant
}

fn change(kind: Kind, bytes: &[u8], rng: &mut ChaCha8Rng) -> (String, Vec<u8>) {
    let text = std::str::from_utf8(bytes).ok().filter(|t| !t.is_empty());
    let Some(text) = text.filter(|_| kind != Kind::Binary) else { return of_bytes(bytes, rng) };
    if kind == Kind::Json
        && rng.random_bool(0.7)
        && let Some(changed) = of_json(text, rng)
    {
        return changed;
    }
    match rng.random_range(0..12) {
        0..5 => of_number(text, rng),
        5..8 => of_line(text, rng),
        8 | 9 => of_word(text, rng),
        10 => of_quoted(text, rng),
        _ => of_bytes(bytes, rng),
    }
}

fn pick<'a, T>(all: &'a [T], rng: &mut ChaCha8Rng) -> &'a T {
    &all[rng.random_range(0..all.len())]
}

/// Bytes turned, put in or cut off.
fn of_bytes(bytes: &[u8], rng: &mut ChaCha8Rng) -> (String, Vec<u8>) {
    let mut out = bytes.to_vec();
    if out.is_empty() {
        return ("nothing to change".to_owned(), out);
    }
    let at = rng.random_range(0..out.len());
    let what = match rng.random_range(0..6) {
        0 => {
            out.truncate(at);
            format!("cut at byte {at}")
        }
        1 => {
            out[at] ^= 1 << rng.random_range(0..8);
            format!("byte {at} with a bit turned")
        }
        2 => {
            out[at] = *pick(&[0, 1, 127, 128, 255, b'\n', b'"', b'<'], rng);
            format!("byte {at} is {}", out[at])
        }
        3 => {
            let more: Vec<u8> = (0..rng.random_range(1..9)).map(|_| rng.random()).collect();
            out.splice(at..at, more);
            format!("bytes put in at {at}")
        }
        4 => {
            let to = (at + rng.random_range(1..64)).min(out.len());
            out.drain(at..to);
            format!("bytes {at} to {to} left out")
        }
        _ => {
            // A number of four bytes, as counts and sizes are.
            let value = *pick(&[0, 1, u32::MAX, i32::MAX as u32, 0x7F80_0000, 0x7FC0_0000], rng);
            for (i, b) in value.to_le_bytes().into_iter().enumerate() {
                if let Some(place) = out.get_mut(at / 4 * 4 + i) {
                    *place = b;
                }
            }
            format!("bytes from {} are {value:#x}", at / 4 * 4)
        }
    };
    (what, out)
}

/// Where words of some letters stand.
fn spans(text: &str, is_part: impl Fn(u8) -> bool) -> Vec<std::ops::Range<usize>> {
    let mut found = Vec::new();
    let mut from = None;
    for (i, b) in text.bytes().chain([0]).enumerate() {
        match (is_part(b), from) {
            (true, None) => from = Some(i),
            (false, Some(start)) => {
                found.push(start..i);
                from = None;
            }
            _ => {}
        }
    }
    found
}

fn put(text: &str, at: std::ops::Range<usize>, new: &str) -> Vec<u8> {
    format!("{}{new}{}", &text[..at.start], &text[at.end..]).into_bytes()
}

/// A number that is none, is far off, or is in another unit.
fn of_number(text: &str, rng: &mut ChaCha8Rng) -> (String, Vec<u8>) {
    let mut all = spans(text, |b| b.is_ascii_digit() || b"+-.eE".contains(&b));
    all.retain(|at| text[at.clone()].parse::<f64>().is_ok());
    if all.is_empty() {
        return of_bytes(text.as_bytes(), rng);
    }
    let at = pick(&all, rng).clone();
    let old = &text[at.clone()];
    let value = old.parse::<f64>().unwrap_or(0.0);
    let new = match rng.random_range(0..8) {
        0 => (1000.0 * value).to_string(),
        1 => (value / 1000.0).to_string(),
        2 => (57.3 * value).to_string(),
        3 => (-value).to_string(),
        _ => (*pick(&NUMBERS, rng)).to_owned(),
    };
    (format!("`{old}` at byte {} is `{new}`", at.start), put(text, at, &new))
}

/// A line left out, doubled, moved, or many times there.
fn of_line(text: &str, rng: &mut ChaCha8Rng) -> (String, Vec<u8>) {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let (a, b) = (rng.random_range(0..lines.len()), rng.random_range(0..lines.len()));
    let what = match rng.random_range(0..6) {
        0 | 1 => {
            lines.remove(a);
            format!("without line {}", a + 1)
        }
        2 => {
            lines.insert(b, lines[a]);
            format!("line {} again at {}", a + 1, b + 1)
        }
        3 => {
            lines.swap(a, b);
            format!("lines {} and {} swapped", a + 1, b + 1)
        }
        4 => {
            let to = (a + rng.random_range(1..8)).min(lines.len());
            lines.drain(a..to);
            format!("without lines {} to {to}", a + 1)
        }
        _ => {
            let line = lines[a];
            lines.splice(a..a, std::iter::repeat_n(line, 200));
            format!("line {} 200 times", a + 1)
        }
    };
    (what, lines.concat().into_bytes())
}

/// A word that is another of the file: names twice, cycles, kinds that do not fit.
fn of_word(text: &str, rng: &mut ChaCha8Rng) -> (String, Vec<u8>) {
    let all = spans(text, |b| b.is_ascii_alphanumeric() || b == b'_');
    if all.is_empty() {
        return of_bytes(text.as_bytes(), rng);
    }
    let (at, from) = (pick(&all, rng).clone(), pick(&all, rng).clone());
    let (old, new) = (&text[at.clone()], &text[from]);
    (format!("`{old}` at byte {} is `{new}`", at.start), put(text, at, new))
}

/// A quoted text that is no name.
fn of_quoted(text: &str, rng: &mut ChaCha8Rng) -> (String, Vec<u8>) {
    let quotes: Vec<usize> = text.match_indices('"').map(|(i, _)| i).collect();
    if quotes.len() < 2 {
        return of_word(text, rng);
    }
    let i = rng.random_range(0..quotes.len() / 2);
    let at = quotes[2 * i] + 1..quotes[2 * i + 1];
    let old = &text[at.clone()];
    if rng.random_bool(0.1) {
        return (format!("`{old}` is long"), put(text, at, &"x".repeat(DEEP)));
    }
    let new = *pick(&WORDS, rng);
    (format!("`{old}` at byte {} is {new:?}", at.start), put(text, at, new))
}

/// A member of another kind or size, left out, or put elsewhere.
fn of_json(text: &str, rng: &mut ChaCha8Rng) -> Option<(String, Vec<u8>)> {
    use serde_json::{Value, json};
    let mut whole: Value = serde_json::from_str(text).ok()?;
    let mut all = Vec::new();
    pointers(&whole, String::new(), &mut all);
    let at = pick(&all, rng).clone();
    let other = whole.pointer(pick::<String>(&all, rng))?.clone();
    let (parent, key) = at.rsplit_once('/')?;
    let key = key.replace("~1", "/").replace("~0", "~");
    let odd = [
        json!(null),
        json!([]),
        json!({}),
        json!(""),
        json!("../../x"),
        json!(0),
        json!(-1),
        json!(1e308),
        json!(-1e308),
        json!(1e-320),
        json!(u64::MAX),
        json!(i64::MIN),
        json!(0.5),
        json!(true),
        json!([[]]),
        json!("nan"),
        json!(2),
    ];
    let what = match rng.random_range(0..8) {
        0 => {
            match whole.pointer_mut(parent)? {
                Value::Object(members) => drop(members.remove(&key)),
                Value::Array(items) => drop(items.remove(key.parse().ok()?)),
                _ => {}
            }
            format!("without {at}")
        }
        1 => {
            if let Value::Array(items) = whole.pointer_mut(parent)? {
                let i: usize = key.parse().ok()?;
                items.insert(i, items[i].clone());
            }
            format!("{at} twice")
        }
        2 => {
            if let Value::Array(items) = whole.pointer_mut(&at)? {
                items.reverse();
            }
            format!("{at} reversed")
        }
        3 => {
            *whole.pointer_mut(&at)? = other;
            format!("{at} is another member")
        }
        4 => {
            let value = whole.pointer(&at)?.as_f64()?;
            let new = *pick(&[1000.0, 1e-3, 57.3, -1.0, 1.0 + 1e-6], rng) * value;
            *whole.pointer_mut(&at)? = json!(new);
            format!("{at} is {new}")
        }
        _ => {
            let new = pick(&odd, rng).clone();
            let what = format!("{at} is {new}");
            *whole.pointer_mut(&at)? = new;
            what
        }
    };
    Some((what, whole.to_string().into_bytes()))
}

/// Pointers to all members; of a long list to its ends.
fn pointers(value: &serde_json::Value, at: String, found: &mut Vec<String>) {
    match value {
        serde_json::Value::Object(members) => {
            for (key, inner) in members {
                pointers(
                    inner,
                    format!("{at}/{}", key.replace('~', "~0").replace('/', "~1")),
                    found,
                );
            }
        }
        serde_json::Value::Array(items) => {
            for (i, inner) in items.iter().enumerate() {
                if i < 3 || i + 2 > items.len() {
                    pointers(inner, format!("{at}/{i}"), found);
                }
            }
        }
        _ => {}
    }
    if !at.is_empty() {
        found.push(at);
    }
}
