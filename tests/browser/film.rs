//! Frames that play, on a page of their own: the script of the report moves a picture of four frames.

use std::path::Path;

use libtest_mimic::Failed;

const SCRIPT: &str = include_str!("../../crates/report/src/html/film.js");
const STYLE: &str = include_str!("../../crates/report/src/html/film.css");

/// Plays for a second, pauses, and moves the slider to the last frame.
const ACTIONS: &str = "
const film = document.querySelector('.film');
const [button, slider, image] = ['button', 'input', 'img'].map((name) => film.querySelector(name));
const seen = { still: image.style.objectPosition, play: button.textContent };
setTimeout(() => {
  button.click();
  seen.playing = button.textContent;
  setTimeout(() => {
    seen.moved = Number(slider.value);
    button.click();
    seen.paused = button.textContent;
    slider.value = 3;
    slider.dispatchEvent(new Event('input'));
    seen.last = image.style.objectPosition;
    seen.told = slider.getAttribute('aria-valuetext');
    seen.complaints = window.complaints;
    const pre = document.createElement('pre');
    pre.id = 'seen';
    pre.textContent = JSON.stringify(seen);
    document.body.append(pre);
  }, 300);
}, 300);
";

pub fn frames_play(program: &Path) -> Result<(), Failed> {
    let picture = "data:image/gif;base64,R0lGODlhAQABAAAAACH5BAEKAAEALAAAAAABAAEAAAICTAEAOw==";
    let page = format!(
        "<!doctype html><html><head><style>{STYLE}</style></head><body>\
         <figure class=\"film\" data-frames=\"[1,3,5,7]\"><img alt=\"a film\" src=\"{picture}\" \
         style=\"aspect-ratio: 4 / 1\"></figure><script>{SCRIPT}</script></body></html>"
    );
    for (flags, labels, moves) in [
        (&[][..], ["Play", "Pause", "Play"], 1..4),
        // One frame for each time that it is pressed.
        (&["--force-prefers-reduced-motion"][..], ["Next frame", "Next frame", "Next frame"], 1..2),
    ] {
        let folder = tempfile::tempdir()?;
        let seen = super::driven(program, folder.path(), &page, ACTIONS, flags)?;
        assert_eq!(seen["complaints"], serde_json::json!([]), "{seen}");
        assert_eq!([&seen["play"], &seen["playing"], &seen["paused"]], labels, "{seen}");
        assert!(moves.contains(&seen["moved"].as_u64().unwrap_or_default()), "{seen}");
        assert_eq!((&seen["still"], &seen["last"]), (&"0px 0%".into(), &"0px 100%".into()), "{seen}");
        assert_eq!(seen["told"], "frame 7", "{seen}");
    }
    Ok(())
}
