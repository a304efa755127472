// What goes wrong in a simulated flight, and when: --fail WHAT[=VALUE]@SECONDS[+SECONDS].
//
// WHAT is one of a few names, or PART.FAULT: a device of the board, `motor_1` and so on, `servo_1`
// and so on, `motors` or `wind`, and what is wrong with it. Of a sensor, FAULT is
// [QUANTITY_][AXIS_]NAME, such as offset, accel_offset or accel_z_offset. Stator knows which parts
// a graph has and what they can do.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace stator::world {

enum class FaultKind : std::uint8_t {
    kGnssLoss,     // the receiver has no fix
    kGnssGlitch,   // the fix is VALUE metres off
    kBaroLoss,     // the barometer measures nothing
    kMissionLoss,  // the mission is gone
    kRcLoss,       // the receiver hears nothing, repeats the last frame, and says so
    kBatteryLow,   // at most VALUE is left of the battery, for good
    // Of a sensor.
    kOffset,       // VALUE is added
    kDrift,        // VALUE is added a second
    kStuck,        // the last sample comes again and again
    kNoise,        // white, of this standard deviation
    kSpike,        // one sample of a hundred is VALUE off
    kSaturation,   // no component is beyond VALUE
    kTimeJump,     // time stamps are VALUE seconds late
    kDelay,        // samples come VALUE seconds late
    kDropOut,      // no samples
    kSwappedAxis,  // x and y are exchanged
    kWrongSign,
    // Of a pitot tube.
    kPitotBlocked,   // the tube is closed, its drain open: it reads nothing
    kPitotTrapped,   // both are closed, so it reads height
    kStaticBlocked,  // the static port is closed
    kIce,            // its airspeed falls to nothing within VALUE seconds
    // Of the radio receiver.
    kSilence,     // no frames
    kPreset,      // sticks as programmed for this case: level, throttle down; and it says nothing
    kStuckStick,  // sticks stay; switches work
    // Of a motor, and of all.
    kLoss,
    kPartial,     // thrusts VALUE times what it should
    kMotorStuck,  // the controller holds its last command
    // Of a node.
    kHang,  // it does not run, and its outputs keep what they have
    // Of the battery.
    kSag,         // VALUE times the voltage
    kWeakSupply,  // no more than VALUE amperes
    kDead,        // no voltage
    // Of the links between machines.
    kCut,  // nothing comes through; kNoise: VALUE is the part of all bytes that is damaged
    // Of a machine.
    kKill,    // it stops, and starts again as at first
    kFreeze,  // it stops, and goes on where it stopped
    // Of the wind.
    kWindSpeed,  // VALUE m/s more
};

struct Fault {
    static constexpr std::size_t kLongestName = 24;

    FaultKind kind;
    double value = 0.0;
    std::uint64_t from_us = 0;
    std::uint64_t until_us = 0;
    std::array<char, kLongestName> part{};      // empty: that of the kind
    std::array<char, kLongestName> quantity{};  // empty: all of the part
    int axis = -1;                              // 0 to 2; else none

    bool is_of(std::string_view name) const { return name == part.data(); }
    bool acts(std::uint64_t time_us) const { return time_us >= from_us && time_us < until_us; }
};

class Faults {
  public:
    static constexpr unsigned kMax = 16;

    // False if there are too many.
    [[nodiscard]] bool add(const Fault& fault);
    // The value of a fault that is there now, the last one that was given; nothing if all is well.
    std::optional<double> now(FaultKind kind, std::uint64_t time_us) const;
    std::optional<double> now(std::string_view part, FaultKind kind, std::uint64_t time_us) const;

    const Fault* begin() const { return faults_.data(); }
    const Fault* end() const { return faults_.data() + count_; }

  private:
    std::array<Fault, kMax> faults_{};
    unsigned count_ = 0;
};

// Reads one fault as the command line gives it; nothing, if it is none.
std::optional<Fault> read_fault(const char* text);
// The names of faults, for messages.
extern const char* const kFaultNames;

}  // namespace stator::world
