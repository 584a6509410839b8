//! Settings that form groups in the code but a flat list in the file. In: fields with doc, limits and default, each written once. Out:
//! the struct with its groups; its file, flags and widgets, which have no groups.
//!
//! Serde's `flatten` is not used for two reasons: it no longer rejects an unknown key, and errors lose their line.

/// Defines a struct of settings: ungrouped fields, groups of fields, and again ungrouped fields, in the order of the file.
///
/// ```text
/// flat_settings! {
///     /// Purpose of the struct
///     pub struct Name, written as name_file {
///         fields { /// Doc, which becomes the help text
///                  #[schemars(range(min = 1, max = 9))]
///                  count: u32 = 3, }
///         /// Purpose of the group
///         group display: Display { /// Doc
///                                  width_m: f64 = 1.0, }
///         fields {}
///     }
/// }
/// ```
macro_rules! flat_settings {
    (
        $(#[doc = $about:literal])+
        pub struct $name:ident, written as $file:ident {
            fields { $(
                $(#[doc = $first_doc:literal])+
                $(#[schemars $first_limits:tt])?
                $(#[serde $first_names:tt])?
                $first:ident: $first_type:ty = $first_default:expr,
            )* }
            $(
                $(#[doc = $group_about:literal])+
                group $group:ident: $group_type:ident { $(
                    $(#[doc = $doc:literal])+
                    $(#[schemars $limits:tt])?
                    $(#[serde $names:tt])?
                    $field:ident: $field_type:ty = $default:expr,
                )* }
            )*
            fields { $(
                $(#[doc = $last_doc:literal])+
                $(#[schemars $last_limits:tt])?
                $(#[serde $last_names:tt])?
                $last:ident: $last_type:ty = $last_default:expr,
            )* }
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $( $(#[doc = $first_doc])+ pub $first: $first_type, )*
            $( $(#[doc = $group_about])+ pub $group: $group_type, )*
            $( $(#[doc = $last_doc])+ pub $last: $last_type, )*
        }

        $(
            $(#[doc = $group_about])+
            #[derive(Clone, Debug, PartialEq)]
            pub struct $group_type {
                $( $(#[doc = $doc])+ pub $field: $field_type, )*
            }

            impl Default for $group_type {
                fn default() -> Self {
                    Self { $( $field: $default, )* }
                }
            }
        )*

        /// Flat form of the struct, as it is written to files.
        mod $file {
            use super::*;

            #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
            #[serde(deny_unknown_fields, default)]
            pub struct $name {
                $(
                    $(#[doc = $first_doc])+
                    $(#[schemars $first_limits])?
                    $(#[serde $first_names])?
                    pub $first: $first_type,
                )*
                $($(
                    $(#[doc = $doc])+
                    $(#[schemars $limits])?
                    $(#[serde $names])?
                    pub $field: $field_type,
                )*)*
                $(
                    $(#[doc = $last_doc])+
                    $(#[schemars $last_limits])?
                    $(#[serde $last_names])?
                    pub $last: $last_type,
                )*
            }

            impl Default for $name {
                fn default() -> Self {
                    super::$name::default().into()
                }
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    $( $first: $first_default, )*
                    $( $group: $group_type::default(), )*
                    $( $last: $last_default, )*
                }
            }
        }

        impl From<$file::$name> for $name {
            fn from(flat: $file::$name) -> Self {
                Self {
                    $( $first: flat.$first, )*
                    $( $group: $group_type { $( $field: flat.$field, )* }, )*
                    $( $last: flat.$last, )*
                }
            }
        }

        impl From<$name> for $file::$name {
            fn from(grouped: $name) -> Self {
                Self {
                    $( $first: grouped.$first, )*
                    $($( $field: grouped.$group.$field, )*)*
                    $( $last: grouped.$last, )*
                }
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                $file::$name::from(self.clone()).serialize(serializer)
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                $file::$name::deserialize(deserializer).map(Into::into)
            }
        }

        impl schemars::JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                $file::$name::schema_name()
            }

            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                $file::$name::json_schema(generator)
            }
        }
    };
}

pub(crate) use flat_settings;
