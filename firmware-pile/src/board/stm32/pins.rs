//! Which pin does what: the one table. `docs/pile-board.md` shows the same, and a test compares.

firmware_common::pins! {
    /// Contactor, high closes it. An external pull-down holds it open in a reset.
    contactor: PE15,
    /// Power stage, high lets it give current. An external pull-down holds it off in a reset.
    power_enable: PE14,
    /// Current limit of the power stage, 20 A for each volt: DAC channel 1.
    power_limit: PA4,
    /// Auxiliary contact of the contactor, low when closed.
    contactor_feedback: PE7,
    /// Loop through the robot's contacts, low when they are mated.
    mated: PE8,
    /// Loop through all emergency stops, low when none is pressed; high also when its wire is off.
    emergency_stop: PE9,
    /// Mains monitor, low when there is mains; high also when its wire is off.
    mains: PE10,
    /// Provisioning button, high when held.
    button: PA0,
    /// Output voltage by 390 and 10 kilo-ohm about half the supply: ADC1 channel 10.
    output_voltage: PC0,
    /// Output current, 20 mV/A about half the supply: ADC1 channel 11.
    output_current: PC1,
    /// Contact temperature, NTC to ground and 10 kilo-ohm to the supply: ADC1 channel 12.
    contact_temperature: PC2,
    /// Green: the pile is free.
    led_free: PD12,
    /// Orange: the pile is reserved, charging, or still occupied.
    led_taken: PD13,
    /// Red: the pile has a fault.
    led_fault: PD14,
    /// Blue: the contacts are live.
    led_live: PD15,
    /// To the coordinator, 115200 baud: USART1.
    link_tx: PB6,
    /// From the coordinator: USART1.
    link_rx: PB7,
    /// To the UHF reader, 115200 baud: USART2.
    reader_tx: PA2,
    /// From the UHF reader: USART2.
    reader_rx: PA3,
    /// MFRC522 clock, 1.3 MHz: SPI1.
    tag_clock: PA5,
    /// MFRC522 data out: SPI1.
    tag_miso: PA6,
    /// MFRC522 data in: SPI1.
    tag_mosi: PA7,
    /// MFRC522 chip select, low when selected.
    tag_select: PB0,
    /// Makes the power stage's set-point.
    set_point: DAC1,
    /// The meter of voltage, current and temperature.
    meter: ADC1,
    /// The link.
    link: USART1,
    /// The UHF reader's line.
    reader: USART2,
    /// The MFRC522's bus.
    tag_bus: SPI1,
    /// Keeps what outlives a loss of power.
    flash: FLASH,
    /// Resets the board unless it is fed.
    watchdog: IWDG,
}
