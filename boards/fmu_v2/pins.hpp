// The pins of the Pixhawk FMU, version 2 (its public schematic, FMUv2 REV D).
#pragma once

#include <array>

#include "stm32f4/edge_line.hpp"
#include "stm32f4/gpio.hpp"

namespace stator::board::pins {

using stm32f4::Pin;

inline constexpr Pin kAmberLed('E', 12);            // low lights it; its anode is at 5 V
inline constexpr Pin kSensorSupply('E', 3);         // high: 3.3 V for the sensors
inline constexpr Pin kPeripheralSupplyOff('A', 8);  // low: 5 V for what is plugged in

// Every chip on the sensors' bus, SPI1, the FRAM on SPI2, and what a connector or the sensors of
// the Cube, which is the same board to a bootloader, may have on SPI1 and SPI4: selected by a low
// level.
inline constexpr std::array kSelects{
    Pin('C', 2),   // MPU6000
    Pin('C', 13),  // L3GD20
    Pin('C', 15),  // LSM303D
    Pin('D', 7),   // MS5611
    Pin('D', 10),  // FRAM
    Pin('C', 1),   // compass of the Cube
    Pin('E', 4),   // first chip on SPI4
    Pin('C', 14),  // second chip on SPI4
};

// The bus of the sensors, SPI1, and the line by which the MPU6000 says that it has a sample.
inline constexpr std::array kSensorBus{Pin('A', 5), Pin('A', 6), Pin('A', 7)};
inline constexpr uint32_t kSpiFunction = 5;
inline constexpr Pin kMpu6000Select('C', 2);
inline constexpr stm32f4::EdgeLine kMpu6000Ready('D', 15);

// The bus of the connector CAN: CAN1, with the transceiver on the board, which no pin switches. The
// chip's other controller, CAN2 (PB12, PB6), ends at the expansion connector without one. So say
// PX4's board.h and ArduPilot's hwdef of this board; the pins' function is number 9 in the data
// sheet's table of alternate functions.
inline constexpr Pin kCan1Receive('D', 0);
inline constexpr Pin kCan1Send('D', 1);
inline constexpr uint32_t kCanFunction = 9;

// A connector with a serial line. No flow control: a radio that wants it may always send, and its
// own request is not looked at, as where nothing is plugged in.
struct SerialPins {
    Pin send;
    Pin receive;
    Pin ready;  // low: the other end may send
};
inline constexpr SerialPins kTelem1{{'D', 5}, {'D', 6}, {'D', 4}};   // USART2
inline constexpr SerialPins kTelem2{{'D', 8}, {'D', 9}, {'D', 12}};  // USART3
inline constexpr uint32_t kUsartFunction = 7;

// The connector SERIAL4/5, which has two lines: UART8, and UART7, of which only the sending pin.
inline constexpr Pin kSerial4Send('E', 1);
inline constexpr Pin kSerial4Receive('E', 0);
inline constexpr Pin kSerial5Send('E', 8);
inline constexpr uint32_t kUartFunction = 8;

// Outputs 1 to 6 of the FMU itself; the eight main ones belong to the safety processor, which has
// its own failsafe.
inline constexpr std::array kMotorOutputs{
    Pin('E', 14), Pin('E', 13), Pin('E', 11), Pin('E', 9), Pin('D', 13), Pin('D', 14),
};
inline constexpr std::array<uint32_t, 6> kMotorFunctions{1, 1, 1, 1, 2, 2};  // TIM1, TIM4
inline constexpr std::array<uint32_t, 6> kMotorChannels{4, 3, 2, 1, 2, 3};

}  // namespace stator::board::pins
