"""Runs an image of a board in LabWired and prints what leaves USART1.

python boot.py ELF MILLISECONDS [PIN ...]

The pins, such as e10, are held low; all others are open.

One line for each millisecond in which bytes left: the time in milliseconds, and the bytes in
hexadecimal. The last line is "end" with the core's fault status registers, CFSR and HFSR.
"""

import pathlib
import sys
import tempfile

import labwired

# What the boards use and LabWired's file of their chip does not have.
ADDED = """
  - {id: "tim12", type: "timer", base_address: 0x40001800, size: "1KB", irq: 43}
  - {id: "dac", type: "dac", base_address: 0x40007400, size: "1KB"}
"""
SYSTEM = """
name: "board"
chip: "chip.yaml"
external_devices: []
board_io:
"""
LOW = """
  - {{id: "{pin}", kind: "button", peripheral: "gpio{port}", pin: {number}, signal: "input", active_high: false}}
"""
CFSR = 0xE000ED28
HFSR = 0xE000ED2C


def main(elf, milliseconds, pins):
    configs = pathlib.Path(labwired.__file__).parent / "configs"
    chip = (configs / "chips" / "stm32f407.yaml").read_text()
    chip = chip.replace("../peripherals", str(configs / "peripherals"))
    chip = chip.replace("\nperipherals:\n", "\nperipherals:" + ADDED, 1)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "chip.yaml").write_text(chip)
        held = "".join(LOW.format(pin=pin, port=pin[0], number=pin[1:]) for pin in pins)
        (folder / "system.yaml").write_text(SYSTEM + (held or "  []\n"))
        with labwired.Sim(elf, system=folder / "system.yaml", uart="usart1") as board:
            for pin in pins:
                board.set_pin(pin, True)
            for now in range(1, milliseconds + 1):
                board.run_for("1ms")
                sent = board.read_uart_bytes()
                if sent:
                    print(now, sent.hex(), flush=True)
            print("end", f"{board.read_u32(CFSR):08x}", f"{board.read_u32(HFSR):08x}")


main(sys.argv[1], int(sys.argv[2]), sys.argv[3:])
