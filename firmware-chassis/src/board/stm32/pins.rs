//! Which pin does what: the one table. `docs/chassis-board.md` shows the same, and a test compares.

firmware_common::pins! {
    /// PWM of wheel A, rear left: TIM1 channel 1.
    pwm_a: PE9,
    /// PWM of wheel B, front left: TIM1 channel 2.
    pwm_b: PE11,
    /// PWM of wheel C, front right: TIM1 channel 3.
    pwm_c: PE13,
    /// PWM of wheel D, rear right: TIM1 channel 4.
    pwm_d: PE14,
    /// Direction of wheel A, high forward.
    direction_a: PE7,
    /// Direction of wheel B, high forward.
    direction_b: PE8,
    /// Direction of wheel C, high forward.
    direction_c: PE10,
    /// Direction of wheel D, high forward.
    direction_d: PE12,
    /// Low: all drivers sleep, the motors are open. An external pull-down holds it in a reset.
    drivers_awake: PE15,
    /// Driver of wheel A, low when it reports a fault.
    fault_a: PD0,
    /// Driver of wheel B, low when it reports a fault.
    fault_b: PD1,
    /// Driver of wheel C, low when it reports a fault.
    fault_c: PD2,
    /// Driver of wheel D, low when it reports a fault.
    fault_d: PD3,
    /// Encoder of wheel A, phase A: TIM2 channel 1.
    encoder_a1: PA15,
    /// Encoder of wheel A, phase B: TIM2 channel 2.
    encoder_a2: PB3,
    /// Encoder of wheel B, phase A: TIM3 channel 1.
    encoder_b1: PB4,
    /// Encoder of wheel B, phase B: TIM3 channel 2.
    encoder_b2: PB5,
    /// Encoder of wheel C, phase A: TIM4 channel 1.
    encoder_c1: PD12,
    /// Encoder of wheel C, phase B: TIM4 channel 2.
    encoder_c2: PD13,
    /// Encoder of wheel D, phase A: TIM5 channel 1.
    encoder_d1: PA0,
    /// Encoder of wheel D, phase B: TIM5 channel 2.
    encoder_d2: PA1,
    /// ICM-20948 chip select, low when selected.
    gyro_select: PB12,
    /// ICM-20948 clock: SPI2.
    gyro_clock: PB13,
    /// ICM-20948 data out: SPI2.
    gyro_miso: PB14,
    /// ICM-20948 data in: SPI2.
    gyro_mosi: PB15,
    /// Battery voltage by 5.7: ADC1 channel 14.
    battery_voltage: PC4,
    /// Battery current, 100 mV/A about half the supply: ADC1 channel 15.
    battery_current: PC5,
    /// To the robot's computer, 921600 baud: USART1.
    link_tx: PB6,
    /// From the robot's computer: USART1.
    link_rx: PB7,
    /// To the RFID reader, 115200 baud: USART2.
    reader_tx: PA2,
    /// From the RFID reader: USART2.
    reader_rx: PA3,
    /// Makes the PWM.
    pwm: TIM1,
    /// Counts wheel A.
    counter_a: TIM2,
    /// Counts wheel B.
    counter_b: TIM3,
    /// Counts wheel C.
    counter_c: TIM4,
    /// Counts wheel D.
    counter_d: TIM5,
    /// The gyroscope's bus.
    gyro: SPI2,
    /// The battery's meter.
    meter: ADC1,
    /// The link.
    link: USART1,
    /// The RFID reader's line.
    reader: USART2,
    /// Resets the board unless it is fed.
    watchdog: IWDG,
}
