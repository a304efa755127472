// What firmware and plant tell each other, over two FIFOs: the firmware writes ToPlant, and reads
// one FromPlant after each step. Both sides are little-endian and lay these out alike.
#pragma once

#include <array>
#include <cstdint>

#include "samples.hpp"

namespace stator::link {

// Files in the emulator's working folder.
inline constexpr char kToPlant[] = "to_plant";
inline constexpr char kFromPlant[] = "from_plant";
inline constexpr char kLog[] = "flight.ulg";
inline constexpr char kNonvolatile[] = "nonvolatile";
inline constexpr uint32_t kNonvolatileHead = 4096;  // bytes before the memory's own
inline constexpr char kMission[] = "mission";       // need not be there
// As a word for the firmware: start again after a fault or when asked to, instead of ending the
// emulation.
inline constexpr char kRestart[] = "restart";
// Another one: print what each task took at most, at the end of the flight.
inline constexpr char kFigures[] = "figures";

// The serial lines telem1 and telem2, of which the emulator has the other ends: FIFOs of these
// names with ".in" to the firmware and ".out" from it.
inline constexpr std::array<const char*, 2> kLines{"telem1", "telem2"};
// The rates that the firmware sets. The emulator moves bytes as fast as it can, so the plant keeps
// to them.
inline constexpr std::array<uint32_t, 2> kLine_baud{57'600, 921'600};

struct ToPlant {
    enum class Kind : uint64_t {
        kStep = 1,     // move the world up to time_us, and answer
        kCommand = 2,  // the motors do this from time_us on
        kFinished =
            3,        // the firmware has ended the flight, mostly after the plant declared it over
        kServos = 4,  // the servos do this from time_us on
    };
    Kind kind = Kind::kStep;
    uint64_t time_us = 0;
    std::array<float, 12> control{};  // as ActuatorMotors has it; or ActuatorServos, the first 8
    uint64_t activations = 0;
    uint64_t lost_samples = 0;
    uint64_t missed_samples = 0;  // that a device still busy with the one before did not take
    uint64_t preemptions = 0;
    uint64_t unrecorded_activations = 0;
    uint64_t missed_life_signs = 0;
    uint64_t restarts = 0;  // 1: a restart request ended the flight
};
static_assert(sizeof(ToPlant) == 120);

// What the sensors saw since the step before.
struct FromPlant {
    uint64_t is_over = 0;  // nothing else counts then
    board::Samples samples{};
};

}  // namespace stator::link
