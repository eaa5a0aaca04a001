//! Numbers as text: the same figure has the same digits wherever it is shown.

/// Words with a capital letter at their head.
pub fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |c| c.to_uppercase().chain(letters).collect())
}

/// A share as percent: whole numbers from 10 %, one decimal below; number and sign stay together.
pub fn percent(share: f64) -> String {
    let text = match 100.0 * share {
        p if p.is_nan() => return "unknown".to_owned(),
        0.0 => "0".to_owned(),
        p if p < 0.1 => "<0.1".to_owned(),
        p if p < 9.95 => format!("{p:.1}"),
        // All but a few: never rounded up to certainty.
        p if p > 99.5 && share < 1.0 => ">99".to_owned(),
        p => format!("{p:.0}"),
    };
    text + "\u{a0}%"
}

/// A score or a mean of scores.
pub fn score(value: f64) -> String {
    if value.is_finite() { format!("{value:.2}") } else { "unknown".to_owned() }
}

/// A change, always with its sign.
pub fn change(value: f64) -> String {
    let text = format!("{:.2}", value.abs());
    match text.as_str() {
        "0.00" => "0.00".to_owned(),
        _ if !value.is_finite() => "unknown".to_owned(),
        _ if value < 0.0 => format!("\u{2212}{text}"),
        _ => format!("+{text}"),
    }
}

/// A physical value: four decimals, or powers of ten where these would show nothing.
pub fn value(value: f64) -> String {
    if !value.is_finite() {
        "unknown".to_owned()
    } else if value == 0.0 {
        "0".to_owned()
    } else if value.abs() < 1e-4 {
        format!("{value:.1e}").replace('-', "\u{2212}")
    } else {
        format!("{value:.4}").replace('-', "\u{2212}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        let percents = [0.0, 0.0003, 0.071, 0.384, 0.9999, 1.0].map(percent);
        assert_eq!(percents.join(" ").replace('\u{a0}', ""), "0% <0.1% 7.1% 38% >99% 100%");
        assert_eq!(change(-0.396), "\u{2212}0.40");
        assert_eq!(change(-0.001), "0.00");
        assert_eq!(value(-0.113_832), "\u{2212}0.1138");
    }
}
