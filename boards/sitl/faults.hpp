// What goes wrong in a simulated flight, and when: --fail WHAT[=VALUE]@SECONDS[+SECONDS].
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace stator::board {

enum class FaultKind : std::uint8_t {
    kGnssLoss,     // the receiver has no fix
    kGnssGlitch,   // the fix is VALUE metres off
    kBaroLoss,     // the barometer measures nothing
    kMissionLoss,  // the mission is gone
    kRcLoss,       // the pilot's transmitter is not heard
    kBatteryLow,   // at most VALUE is left of the battery, for good
    kMotor1,       // the first rotor thrusts VALUE times what it should
    kMotor2,
    kMotor3,
    kMotor4,
};

struct Fault {
    FaultKind kind;
    double value;
    std::uint64_t from_us;
    std::uint64_t until_us;
};

class Faults {
  public:
    static constexpr unsigned kMax = 16;

    // False if there are too many.
    [[nodiscard]] bool add(const Fault& fault);
    // The value of a fault that is there now, the last one that was given; nothing if all is well.
    std::optional<double> now(FaultKind kind, std::uint64_t time_us) const;

  private:
    std::array<Fault, kMax> faults_{};
    unsigned count_ = 0;
};

// Reads one fault as the command line gives it; nothing, if it is none.
std::optional<Fault> read_fault(const char* text);
// The names of faults, for messages.
extern const char* const kFaultNames;

}  // namespace stator::board
