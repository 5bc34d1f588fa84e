//! Lines of numbers as text: most of what text formats consist of.

use std::io::Write;

use super::atomic::write_failed;
use crate::error::Result;

/// A line on its way into a file: words with a blank between them. Reals are the shortest text that reads back as the same
/// number.
#[derive(Default)]
pub(super) struct WrittenLine(Vec<u8>);

impl WrittenLine {
    fn part(&mut self) {
        if self.0.last().is_some_and(|c| *c != b'\n') {
            self.0.push(b' ');
        }
    }

    /// Lets `fill` add words, with a comma before each blank between them.
    pub(super) fn commas(&mut self, fill: impl FnOnce(&mut Self)) -> &mut Self {
        let begin = self.0.len();
        fill(self);
        let words = self.0.split_off(begin);
        for c in words {
            self.0.extend((c == b' ').then_some(b','));
            self.0.push(c);
        }
        self
    }

    /// Adds a word as it is.
    pub(super) fn word(&mut self, word: &str) -> &mut Self {
        self.part();
        self.0.extend(word.as_bytes());
        self
    }

    /// Lets `fill` add words, with parentheses around them.
    pub(super) fn parentheses(&mut self, fill: impl FnOnce(&mut Self)) -> &mut Self {
        self.0.push(b'(');
        let mut inside = Self::default();
        fill(&mut inside);
        self.0.extend(inside.0);
        self.0.push(b')');
        self
    }

    /// Adds numbers of at most `width` characters, as near as that allows; 20 hold thirteen digits of any number.
    pub(super) fn narrow(&mut self, numbers: impl Into<[f64; 3]>, width: usize) -> &mut Self {
        for x in numbers.into() {
            let mut buffer = zmij::Buffer::new();
            let text = buffer.format(x);
            if text.len() <= width {
                self.word(text);
                continue;
            }
            let shorter = (1..17).rev().map(|digits| format!("{x:.digits$e}")).find(|t| t.len() <= width);
            self.word(&shorter.unwrap_or_else(|| format!("{x:e}")));
        }
        self
    }

    /// Adds a number.
    pub(super) fn real(&mut self, x: f64) -> &mut Self {
        self.word(zmij::Buffer::new().format(x))
    }

    /// Adds numbers.
    pub(super) fn reals(&mut self, numbers: impl Into<[f64; 3]>) -> &mut Self {
        numbers.into().into_iter().for_each(|x| _ = self.real(x));
        self
    }

    /// Adds a whole number.
    pub(super) fn whole(&mut self, n: impl itoa::Integer) -> &mut Self {
        self.word(itoa::Buffer::new().format(n))
    }

    /// Adds whole numbers.
    pub(super) fn wholes<N: itoa::Integer>(&mut self, numbers: impl IntoIterator<Item = N>) -> &mut Self {
        numbers.into_iter().for_each(|n| _ = self.whole(n));
        self
    }

    /// Begins another line behind this one.
    pub(super) fn and(&mut self) -> &mut Self {
        self.0.push(b'\n');
        self
    }

    /// Ends the line, writes it, and is empty again.
    pub(super) fn end(&mut self, out: &mut dyn Write) -> Result<()> {
        self.0.push(b'\n');
        self.flush(out)
    }

    /// Writes what there is so far.
    pub(super) fn flush(&mut self, out: &mut dyn Write) -> Result<()> {
        out.write_all(&self.0).map_err(write_failed)?;
        self.0.clear();
        Ok(())
    }

    /// Adds bytes as they are.
    pub(super) fn bytes<const N: usize>(&mut self, bytes: [u8; N]) {
        self.0.extend(bytes);
    }
}
