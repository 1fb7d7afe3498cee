//! A board's pin table as code: the one place where a pin is named.

/// Defines `Pins`: the board's pins and the peripherals behind them, by name.
#[macro_export]
macro_rules! pins {
    ($($(#[$doc:meta])* $name:ident: $pin:ident,)*) => {
        /// The board's pins, and the peripherals behind them.
        pub struct Pins {
            $($(#[$doc])* pub $name: embassy_stm32::Peri<'static, embassy_stm32::peripherals::$pin>,)*
        }

        impl Pins {
            /// Takes them out of all there is.
            pub fn take(all: embassy_stm32::Peripherals) -> Self {
                Self { $($name: all.$pin,)* }
            }
        }
    };
}
