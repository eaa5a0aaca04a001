//! The six look-up tables of RULA (1993) and REBA (2000).
//!
//! Every look-up is total: a step score outside its table counts as the nearest one inside. The
//! papers never produce such a score, but worksheets filled in by hand do (an upper arm of 0 after
//! the point for support, a REBA neck of 4), and code without the clamp crashes or wraps there.

use serde::Serialize;

/// Which printing of RULA's table A is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RulaTableA {
    /// The paper's own table (1993, table 1).
    Paper1993,
    /// The table on the widely copied Cornell University worksheet of February 2001, which is lower
    /// in 31 of the 144 cells.
    Cornell2001,
}

/// RULA table A.
type A = [[u8; 8]; 18];

/// Rows: upper arm 1-6, within it lower arm 1-3. Columns: wrist 1-4, within it wrist twist 1-2.
const RULA_A: A = [
    [1, 2, 2, 2, 2, 3, 3, 3],
    [2, 2, 2, 2, 3, 3, 3, 3],
    [2, 3, 3, 3, 3, 3, 4, 4],
    [2, 3, 3, 3, 3, 4, 4, 4],
    [3, 3, 3, 3, 3, 4, 4, 4],
    [3, 4, 4, 4, 4, 4, 5, 5],
    [3, 3, 4, 4, 4, 4, 5, 5],
    [3, 4, 4, 4, 4, 4, 5, 5],
    [4, 4, 4, 4, 4, 5, 5, 5],
    [4, 4, 4, 4, 4, 5, 5, 5],
    [4, 4, 4, 4, 4, 5, 5, 5],
    [4, 4, 4, 5, 5, 5, 6, 6],
    [5, 5, 5, 5, 5, 6, 6, 7],
    [5, 6, 6, 6, 6, 7, 7, 7],
    [6, 6, 6, 7, 7, 7, 7, 8],
    [7, 7, 7, 7, 7, 8, 8, 9],
    [8, 8, 8, 8, 8, 9, 9, 9],
    [9, 9, 9, 9, 9, 9, 9, 9],
];

/// Column and score.
type Cell = (usize, u8);

/// Cells of table A that the Cornell sheet prints otherwise: upper arm, lower arm, then for each of
/// its columns (wrist and twist as `2 * (wrist - 1) + twist - 1`) the score printed there.
const CORNELL_CELLS: [(u8, u8, &[Cell]); 11] = [
    (1, 3, &[(2, 2)]),
    (2, 1, &[(1, 2), (2, 2), (5, 3)]),
    (2, 2, &[(0, 2), (1, 2), (2, 2), (5, 3)]),
    (2, 3, &[(0, 2), (1, 3), (2, 3), (3, 3), (4, 3), (6, 4)]),
    (3, 1, &[(0, 2), (2, 3), (3, 3)]),
    (3, 2, &[(0, 2), (1, 3), (2, 3), (3, 3)]),
    (3, 3, &[(0, 2), (1, 3), (2, 3), (5, 4)]),
    (4, 1, &[(0, 3), (5, 4)]),
    (4, 2, &[(0, 3), (5, 4)]),
    (4, 3, &[(0, 3)]),
    (6, 2, &[(0, 7)]),
];

const RULA_A_CORNELL: A = cornell();

const fn cornell() -> A {
    let mut table = RULA_A;
    let mut i = 0;
    while i < CORNELL_CELLS.len() {
        let (upper, lower, cells) = CORNELL_CELLS[i];
        let row = (upper as usize - 1) * 3 + lower as usize - 1;
        let mut j = 0;
        while j < cells.len() {
            table[row][cells[j].0] = cells[j].1;
            j += 1;
        }
        i += 1;
    }
    table
}

/// Rows: neck 1-6. Columns: trunk 1-6, within it legs 1-2.
const RULA_B: [[u8; 12]; 6] = [
    [1, 3, 2, 3, 3, 4, 5, 5, 6, 6, 7, 7],
    [2, 3, 2, 3, 4, 5, 5, 5, 6, 7, 7, 7],
    [3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 7],
    [5, 5, 5, 6, 6, 7, 7, 7, 7, 7, 8, 8],
    [7, 7, 7, 7, 7, 8, 8, 8, 8, 8, 8, 8],
    [8, 8, 8, 8, 8, 8, 8, 9, 9, 9, 9, 9],
];

/// Rows: score C 1-8 and over. Columns: score D 1-7 and over.
const RULA_C: [[u8; 7]; 8] = [
    [1, 2, 3, 3, 4, 5, 5],
    [2, 2, 3, 4, 4, 5, 5],
    [3, 3, 3, 4, 4, 5, 6],
    [3, 3, 3, 4, 5, 6, 6],
    [4, 4, 4, 5, 6, 7, 7],
    [4, 4, 5, 6, 6, 7, 7],
    [5, 5, 6, 6, 7, 7, 7],
    [5, 5, 6, 7, 7, 7, 7],
];

/// Rows: trunk 1-5. Columns: neck 1-3, within it legs 1-4.
const REBA_A: [[u8; 12]; 5] = [
    [1, 2, 3, 4, 1, 2, 3, 4, 3, 3, 5, 6],
    [2, 3, 4, 5, 3, 4, 5, 6, 4, 5, 6, 7],
    [2, 4, 5, 6, 4, 5, 6, 7, 5, 6, 7, 8],
    [3, 5, 6, 7, 5, 6, 7, 8, 6, 7, 8, 9],
    [4, 6, 7, 8, 6, 7, 8, 9, 7, 8, 9, 9],
];

/// Rows: upper arm 1-6. Columns: lower arm 1-2, within it wrist 1-3.
const REBA_B: [[u8; 6]; 6] = [
    [1, 2, 2, 1, 2, 3],
    [1, 2, 3, 2, 3, 4],
    [3, 4, 5, 4, 5, 5],
    [4, 5, 5, 5, 6, 7],
    [6, 7, 8, 7, 8, 8],
    [7, 8, 8, 8, 9, 9],
];

/// Rows: score A 1-12. Columns: score B 1-12.
const REBA_C: [[u8; 12]; 12] = [
    [1, 1, 1, 2, 3, 3, 4, 5, 6, 7, 7, 7],
    [1, 2, 2, 3, 4, 4, 5, 6, 6, 7, 7, 8],
    [2, 3, 3, 3, 4, 5, 6, 7, 7, 8, 8, 8],
    [3, 4, 4, 4, 5, 6, 7, 8, 8, 9, 9, 9],
    [4, 4, 4, 5, 6, 7, 8, 8, 9, 9, 9, 9],
    [6, 6, 6, 7, 8, 8, 9, 9, 10, 10, 10, 10],
    [7, 7, 7, 8, 9, 9, 9, 10, 10, 11, 11, 11],
    [8, 8, 8, 9, 10, 10, 10, 10, 10, 11, 11, 11],
    [9, 9, 9, 10, 10, 10, 11, 11, 11, 12, 12, 12],
    [10, 10, 10, 11, 11, 11, 11, 12, 12, 12, 12, 12],
    [11, 11, 11, 11, 12, 12, 12, 12, 12, 12, 12, 12],
    [12, 12, 12, 12, 12, 12, 12, 12, 12, 12, 12, 12],
];

/// Index of a score that starts at 1, kept inside a table of `count` entries.
fn at(score: u8, count: usize) -> usize {
    usize::from(score.saturating_sub(1)).min(count - 1)
}

/// RULA table A: posture score of arm and wrist, 1-9.
pub fn rula_table_a(
    printing: RulaTableA,
    upper_arm: u8,
    lower_arm: u8,
    wrist: u8,
    twist: u8,
) -> u8 {
    let table = match printing {
        RulaTableA::Paper1993 => &RULA_A,
        RulaTableA::Cornell2001 => &RULA_A_CORNELL,
    };
    table[at(upper_arm, 6) * 3 + at(lower_arm, 3)][at(wrist, 4) * 2 + at(twist, 2)]
}

/// RULA table B: posture score of neck, trunk and legs, 1-9.
pub fn rula_table_b(neck: u8, trunk: u8, legs: u8) -> u8 {
    RULA_B[at(neck, 6)][at(trunk, 6) * 2 + at(legs, 2)]
}

/// RULA table C: grand score 1-7 of score C (arm, wrist) and score D (neck, trunk, legs).
pub fn rula_table_c(score_c: u8, score_d: u8) -> u8 {
    RULA_C[at(score_c, 8)][at(score_d, 7)]
}

/// REBA table A: neck, trunk and legs, 1-9.
pub fn reba_table_a(neck: u8, trunk: u8, legs: u8) -> u8 {
    REBA_A[at(trunk, 5)][at(neck, 3) * 4 + at(legs, 4)]
}

/// REBA table B: upper arm, lower arm and wrist, 1-9.
pub fn reba_table_b(upper_arm: u8, lower_arm: u8, wrist: u8) -> u8 {
    REBA_B[at(upper_arm, 6)][at(lower_arm, 2) * 3 + at(wrist, 3)]
}

/// REBA table C: score C 1-12 of score A and score B.
pub fn reba_table_c(score_a: u8, score_b: u8) -> u8 {
    REBA_C[at(score_a, 12)][at(score_b, 12)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRINTINGS: [RulaTableA; 2] = [RulaTableA::Paper1993, RulaTableA::Cornell2001];

    /// Sum of a table's cells, their sum weighted by the cell's number, and whether the table is
    /// monotone.
    fn sweep<const N: usize>(sizes: [u8; N], look_up: impl Fn([u8; N]) -> u8) -> (u32, u32, bool) {
        let (mut sum, mut weighted, mut monotone) = (0, 0, true);
        let count: usize = sizes.iter().map(|s| usize::from(*s)).product();
        for cell in 0..count {
            let (mut rest, mut scores) = (cell, [0; N]);
            for (score, size) in scores.iter_mut().zip(sizes).rev() {
                *score = (rest % usize::from(size)) as u8 + 1;
                rest /= usize::from(size);
            }
            let here = look_up(scores);
            sum += u32::from(here);
            weighted += u32::from(here) * (cell as u32 + 1);
            for factor in 0..N {
                let mut worse = scores;
                worse[factor] += 1; // past the end the look-up clamps, and must not fall either
                monotone &= look_up(worse) >= here;
            }
        }
        (sum, weighted, monotone)
    }

    #[test]
    fn no_table_falls_when_a_step_rises_and_checksums_hold() {
        // Sums and index-weighted sums of the published tables, taken from another transcription.
        let [paper, cornell] = PRINTINGS;
        let a = |printing| sweep([6, 3, 4, 2], |[u, l, w, t]| rula_table_a(printing, u, l, w, t));
        assert_eq!(a(paper), (705, 62_122, true));
        assert!(a(cornell).2);
        assert_eq!(sweep([6, 6, 2], |[n, t, l]| rula_table_b(n, t, l)), (438, 18_481, true));
        assert_eq!(sweep([8, 7], |[c, d]| rula_table_c(c, d)), (269, 8757, true));
        assert_eq!(sweep([3, 5, 4], |[n, t, l]| reba_table_a(n, t, l)), (321, 11_189, true));
        assert_eq!(sweep([6, 2, 3], |[u, l, w]| reba_table_b(u, l, w)), (177, 4164, true));
        assert_eq!(sweep([12, 12], |[a, b]| reba_table_c(a, b)), (1192, 103_224, true));
    }

    #[test]
    fn cornell_lowers_31_cells_and_1011_grand_scores() {
        let [paper, cornell] = PRINTINGS;
        let (mut cells, mut grands) = (0, 0);
        for cell in 0..144u8 {
            let (u, l, w, t) = (cell / 24 + 1, cell / 8 % 3 + 1, cell / 2 % 4 + 1, cell % 2 + 1);
            let (p, c) = (rula_table_a(paper, u, l, w, t), rula_table_a(cornell, u, l, w, t));
            assert!(c <= p && p - c <= 2);
            cells += u32::from(c != p);
            for other in 0..72u8 {
                let d = rula_table_b(other / 12 + 1, other / 2 % 6 + 1, other % 2 + 1);
                grands += u32::from(rula_table_c(p, d) != rula_table_c(c, d));
            }
        }
        assert_eq!((cells, grands), (31, 1011));
    }

    #[test]
    fn scores_outside_a_table_count_as_the_nearest_inside() {
        for printing in PRINTINGS {
            assert_eq!(rula_table_a(printing, 0, 0, 0, 0), 1);
            assert_eq!(rula_table_a(printing, 255, 255, 255, 255), 9);
        }
        assert_eq!((rula_table_b(0, 0, 0), rula_table_b(255, 255, 255)), (1, 9));
        assert_eq!((rula_table_c(0, 0), rula_table_c(13, 13)), (1, 7));
        assert_eq!((reba_table_a(0, 0, 0), reba_table_a(4, 6, 9)), (1, 9));
        assert_eq!((reba_table_b(0, 0, 0), reba_table_b(7, 3, 4)), (1, 9));
        assert_eq!((reba_table_c(0, 0), reba_table_c(13, 13)), (1, 12));
    }
}
