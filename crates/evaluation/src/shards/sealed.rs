//! Lines that tell whether they are whole, and findings on such lines.

use crate::provenance::sha256;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD_NO_PAD;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A line with its checksum.
pub(super) fn sealed(content: &str) -> String {
    format!("{content} {}\n", checksum(content))
}

/// The content of a line, if the line is whole.
pub(super) fn unsealed(line: &str) -> Option<&str> {
    let (content, sum) = line.rsplit_once(' ')?;
    (checksum(content) == sum).then_some(content)
}

fn checksum(content: &str) -> String {
    sha256(content.as_bytes())[..8].to_owned()
}

/// On one line, every number bit for bit: a text of decimal digits has no place for what is no number.
pub(super) fn written<K: Serialize, F: Serialize>(key: &K, finding: &F) -> String {
    let mut bytes = Vec::new();
    // Neither memory nor what findings are made of can refuse to be written; what came out short would be refused on reading.
    let _ = ciborium::into_writer(&(key, finding), &mut bytes);
    sealed(&STANDARD_NO_PAD.encode(bytes))
}

/// Back from the content of a line.
pub(super) fn read<K: DeserializeOwned, F: DeserializeOwned>(content: &str) -> Option<(K, F)> {
    ciborium::from_reader(STANDARD_NO_PAD.decode(content).ok()?.as_slice()).ok()
}

/// The first characters of a hash, for messages.
pub(super) fn short(hash: &str) -> &str {
    hash.get(..12).unwrap_or(hash)
}

/// Why a file for other inputs is refused.
pub(super) fn foreign(theirs: &str, ours: &str) -> String {
    format!(
        "belongs to another search or run: its inputs are {}, those of this run are {} (experiment, scenes, seed, scale and \
         program must be the same)",
        short(theirs),
        short(ours)
    )
}
