// The model of the chip as a program, for firmware in the emulator that flies nothing: starts,
// answers for a time, and says what happened, as JSON.
//   chip_server SOCKET SECONDS [--line NAME FILE]...
// A line's file gets the bytes that the firmware sends there.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <list>
#include <string>
#include <string_view>

#include "chip/chip.hpp"
#include "chip/spi.hpp"
#include "chip/usart.hpp"
#include "emulator.hpp"
#include "parts/mpu6000.hpp"

namespace {

using namespace stator::chip;

constexpr uint32_t kCrystal_hz = 24'000'000;  // of the Pixhawk

int serve(int count, char** words) {
    Emulator emulator(words[1]);
    Chip chip(emulator, kCrystal_hz);
    std::list<std::ofstream> files;
    for (int i = 3; i + 2 < count; i += 3) {
        if (std::string_view(words[i]) != "--line") return 2;
        std::ofstream& file = files.emplace_back(words[i + 2], std::ios::binary);
        chip.usart(words[i + 1]).watch([&file](uint8_t byte) {
            file.put(static_cast<char>(byte));
        });
    }
    // At rest, level: the part's axes are those of this board (docs/boards.md).
    Mpu6000 imu(chip, pin('D', 15), [](uint64_t now_ns) {
        const double noise = 0.002 * static_cast<double>(now_ns / 1'000'000 % 7);
        return Mpu6000::Motion{.rate = {noise, 0, 0}, .force = {0, 0, -9.80665}};
    });
    chip.spi("SPI1").attach(imu, pin('C', 2));
    emulator.serve(chip, static_cast<uint64_t>(std::strtod(words[2], nullptr) * 1e9));
    std::printf(
        "{\"time_us\": %llu, \"accesses\": %llu, \"core_clock_hz\": %u, \"resets\": %u, "
        "\"imu_samples\": %llu, \"imu_read\": %llu, \"imu_missed\": %llu}\n",
        static_cast<unsigned long long>(chip.now_ns() / 1000),
        static_cast<unsigned long long>(emulator.accesses()), chip.clocks().core_hz,
        emulator.resets(), static_cast<unsigned long long>(imu.samples()),
        static_cast<unsigned long long>(imu.bursts()),
        static_cast<unsigned long long>(imu.missed()));
    return 0;
}

}  // namespace

int main(int count, char** words) {
    if (count < 3 || count % 3 != 0) {
        std::fprintf(stderr, "usage: chip_server SOCKET SECONDS [--line NAME FILE]...\n");
        return 2;
    }
    try {
        return serve(count, words);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 1;
    }
}
