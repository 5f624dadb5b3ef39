//! The words of the language: enumerations whose members have a signature and a meaning.
//!
//! The parser finds words by name, messages show signatures, the reference lists both; so each word is written down once.

/// Defines an enumeration of words, each with its signature and its meaning.
macro_rules! vocabulary {
    (
        $(#[$attribute:meta])*
        pub enum $Words:ident {
            $($Word:ident: $signature:literal, $summary:literal;)*
        }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum $Words {
            $(
                #[doc = concat!("`", $signature, "`: ", $summary)]
                $Word,
            )*
        }

        impl $Words {
            /// Every one of them.
            pub const ALL: &[Self] = &[$(Self::$Word),*];

            /// The name in the language, with its arguments.
            pub fn signature(self) -> &'static str {
                match self {
                    $(Self::$Word => $signature,)*
                }
            }

            /// The meaning, in a line.
            pub fn summary(self) -> &'static str {
                match self {
                    $(Self::$Word => $summary,)*
                }
            }

            /// The name in the language.
            pub fn name(self) -> &'static str {
                let signature = self.signature();
                signature.split('(').next().unwrap_or(signature)
            }

            /// The one of that name.
            pub fn named(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|word| word.name() == name)
            }
        }
    };
}

pub(crate) use vocabulary;
