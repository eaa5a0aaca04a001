//! By what a file is known as one that ergopath wrote.

/// How much of a file is looked at.
const HEAD: usize = 2048;
/// What a picture carries: the keyword and text of its `Software` entry.
const PICTURE: &[u8] = b"tEXtSoftware\0ergopath";
/// Kinds of `ergopath/<kind>/<version>` that the program writes and people do not edit.
const KINDS: [&str; 3] = ["posture-model", "unfinished", "schema"];
/// Words in the head of other files.
const WORDS: [(&str, &str); 2] =
    [("name=\"generator\" content=\"ergopath\"", "page"), (".TH ergopath", "man")];
/// First words of tables whose columns no other program has.
const TABLES: [(&str, &str); 2] =
    [("stage,seconds\n", "timings"), ("name,scenario,state,body,", "comparison")];

/// Kind of a file that only ergopath writes, from its beginning; none where that cannot be told.
/// Bodies, scenarios, worksheets and training data are not told: people make and edit them.
pub(super) fn signature(bytes: &[u8]) -> Option<&'static str> {
    let head = &bytes[..bytes.len().min(HEAD)];
    if head.starts_with(b"\x89PNG") {
        return head.windows(PICTURE.len()).any(|w| w == PICTURE).then_some("figure");
    }
    let text = String::from_utf8_lossy(head);
    if let Some((_, id)) = text.split_once("ergopath/") {
        let kind = id.split('/').next().unwrap_or_default();
        if let Some(known) = KINDS.iter().find(|k| **k == kind) {
            return Some(known);
        }
    }
    let words = WORDS.iter().find(|(words, _)| text.contains(words));
    let table = || TABLES.iter().find(|(words, _)| text.starts_with(words));
    words.or_else(table).map(|(_, kind)| *kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_people_do_not_write_is_known() {
        assert_eq!(signature(br#"{"schema":"ergopath/posture-model/2"}"#), Some("posture-model"));
        assert_eq!(signature(b"stage,seconds\nplan,1.0\n"), Some("timings"));
        let others: [&[u8]; 5] = [
            b"schema = \"ergopath/scenario/1\"\n",
            b"q0,q1,xdot0,train,traj\n",
            b"stage,seconds,note\n",
            b"\x89PNG\r\n\x1a\n and a picture of somebody",
            b"",
        ];
        for other in others {
            assert_eq!(signature(other), None);
        }
    }
}
