//! Words of a page: what stands in a paragraph, a sentence of the answer or a cell of a table.

/// A piece of text in one style. Only [`Span::Prose`] is Markdown; everything else is shown as it is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Span {
    Plain(String),
    Code(String),
    Emphasis(String),
    Strong(String),
    /// What is shown, and where it leads: a file beside the page or `#section`.
    Link(String, String),
    /// Inline Markdown by the experiment's author: `question` and `expectation` of its TOML, and nothing else.
    Prose(String),
}

/// Pieces of text one after another.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Text(pub(crate) Vec<Span>);

impl Text {
    fn with(mut self, span: Span) -> Self {
        self.0.push(span);
        self
    }

    pub(crate) fn and(self, text: impl Into<String>) -> Self {
        self.with(Span::Plain(text.into()))
    }

    pub(crate) fn code(self, text: impl Into<String>) -> Self {
        self.with(Span::Code(text.into()))
    }

    pub(crate) fn emphasis(self, text: &str) -> Self {
        self.with(Span::Emphasis(text.to_owned()))
    }

    pub(crate) fn strong(self, text: &str) -> Self {
        self.with(Span::Strong(text.to_owned()))
    }

    pub(crate) fn link(self, text: impl Into<String>, to: impl Into<String>) -> Self {
        self.with(Span::Link(text.into(), to.into()))
    }

    pub(crate) fn prose(self, markdown: impl Into<String>) -> Self {
        self.with(Span::Prose(markdown.into()))
    }

    /// Texts with the same words between each two.
    pub(crate) fn joined(texts: impl IntoIterator<Item = Self>, between: &str) -> Self {
        let mut all = Self::default();
        for (i, text) in texts.into_iter().enumerate() {
            if i > 0 {
                all = all.and(between);
            }
            all.0.extend(text.0);
        }
        all
    }
}

/// Words in a fixed-width font.
pub(crate) fn code(text: impl Into<String>) -> Text {
    Text::default().code(text)
}

impl From<String> for Text {
    fn from(text: String) -> Self {
        Self(vec![Span::Plain(text)])
    }
}

impl From<&String> for Text {
    fn from(text: &String) -> Self {
        text.as_str().into()
    }
}

impl From<&str> for Text {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

macro_rules! from_number {
    ($($number:ty),*) => {
        $(impl From<$number> for Text {
            fn from(value: $number) -> Self {
                value.to_string().into()
            }
        })*
    };
}
from_number!(u32, u64, usize);

/// A dash where there is nothing to say.
impl<T: Into<Text>> From<Option<T>> for Text {
    fn from(value: Option<T>) -> Self {
        value.map_or_else(|| "-".into(), Into::into)
    }
}
