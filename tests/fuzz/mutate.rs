//! Seeded mutations: the same number gives the same bytes, on every machine.

/// Numbers that readers trip over.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "0.5",
    "1e-320",
    "1e308",
    "-1e308",
    "1e999",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "127",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "-2147483649",
    "9223372036854775807",
    "18446744073709551616",
    "99999999999999999999999999",
    "1.0000001",
    "0x10",
    "1_000",
    "1,5",
    "",
];

/// splitmix64 (Steele, Lea, Flood, 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`, 0 where n is 0.
    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    fn pick<'a, T: ?Sized>(&mut self, from: &[&'a T]) -> Option<&'a T> {
        from.get(self.below(from.len())).copied()
    }
}

/// One of the seeds, broken in one to eight ways.
pub fn mutated(seeds: &[&[u8]], words: &[&str], case: u64) -> Vec<u8> {
    let mut random = Random(case);
    let mut bytes = random.pick(seeds).unwrap_or_default().to_vec();
    for _ in 0..1 + random.below(8) {
        let (at, len) = (random.below(bytes.len() + 1), bytes.len());
        let end = (at + random.below(32)).min(len);
        match random.below(12) {
            0 if at < len => bytes[at] ^= 1 << random.below(8),
            1 if at < len => bytes[at] = random.next() as u8,
            2 => drop(bytes.drain(at..end)),
            3 => {
                let copy = bytes[at..end].to_vec();
                let to = random.below(len + 1);
                bytes.splice(to..to, copy);
            }
            4 => {
                let other = random.pick(seeds).unwrap_or_default();
                let from = random.below(other.len());
                let to = (from + random.below(64)).min(other.len());
                bytes.splice(at..end, other[from..to].iter().copied());
            }
            5 => bytes.truncate(at),
            6 | 7 => {
                // A word of the format, now and then a hundred times over.
                let word = random.pick(words).unwrap_or_default();
                let times = if random.below(20) == 0 { 100 } else { 1 };
                bytes.splice(at..at, word.as_bytes().repeat(times));
            }
            8 => {
                let (a, b) = (token(&bytes, random.below(len)), token(&bytes, random.below(len)));
                let (first, second) = if a.start < b.start { (a, b) } else { (b, a) };
                if first.end <= second.start {
                    let (x, y) = (bytes[first.clone()].to_vec(), bytes[second.clone()].to_vec());
                    bytes.splice(second, x);
                    bytes.splice(first, y);
                }
            }
            9 => {
                let token = token(&bytes, at);
                bytes.splice(token, random.pick(words).unwrap_or_default().bytes());
            }
            _ => {
                // The next number from here on, and another one in its place.
                let digit = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
                if let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|p| at + p) {
                    let end = start + bytes[start..].iter().position(|b| !digit(b)).unwrap_or(len - start);
                    bytes.splice(start..end, random.pick(NUMBERS).unwrap_or_default().bytes());
                }
            }
        }
    }
    bytes
}

/// The word around a place.
fn token(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let inside = |b: &u8| b.is_ascii_alphanumeric() || b"_-+.".contains(b) || *b >= 128;
    let start = bytes[..at.min(bytes.len())].iter().rposition(|b| !inside(b)).map_or(0, |p| p + 1);
    let end = bytes[start..].iter().position(|b| !inside(b)).map_or(bytes.len(), |p| start + p);
    start..end
}

#[test]
fn the_same_case_gives_the_same_bytes() {
    let seeds: &[&[u8]] = &[b"v 1 2 3\nf 1 2 3\n", b"o x\n"];
    let all: Vec<_> = (0..1000).map(|case| mutated(seeds, &["usemtl"], case)).collect();
    assert_eq!(all, (0..1000).map(|case| mutated(seeds, &["usemtl"], case)).collect::<Vec<_>>());
    assert!(all.iter().collect::<std::collections::HashSet<_>>().len() > 700);
}
