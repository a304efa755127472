// What is told unasked, and how often.
#pragma once

#include <array>
#include <cstdint>

#include "link.hpp"
#include "mavlink/messages.hpp"

namespace stator::apps::mavlink {

// A message that can be told at an interval, and its usual intervals by the line's role; 0: not
// unless asked.
struct Stream {
    uint16_t id;
    uint16_t usual_ms;    // to a ground station or a radio
    uint16_t onboard_ms;  // to a computer on board
};

inline constexpr std::array kStreams{
    Stream{mav::Heartbeat::kId, 1000, 1000},
    Stream{mav::SysStatus::kId, 1000, 1000},
    Stream{mav::Attitude::kId, 250, 100},
    Stream{mav::GlobalPositionInt::kId, 250, 100},
    Stream{mav::LocalPositionNed::kId, 500, 100},
    Stream{mav::GpsRawInt::kId, 1000, 200},
    Stream{mav::VfrHud::kId, 250, 250},
    Stream{mav::ExtendedSysState::kId, 1000, 500},
    Stream{mav::MissionCurrent::kId, 1000, 1000},
    Stream{mav::BatteryStatus::kId, 2000, 1000},
    Stream{mav::HomePosition::kId, 2000, 1000},
    Stream{mav::SystemTime::kId, 2000, 1000},
    Stream{mav::Altitude::kId, 1000, 200},
    Stream{mav::AttitudeQuaternion::kId, 0, 100},
    Stream{mav::HighresImu::kId, 1000, 200},
    Stream{mav::Odometry::kId, 0, 0},
    Stream{mav::CurrentMode::kId, 2000, 2000},
    Stream{mav::RcChannels::kId, 1000, 0},
    Stream{mav::OrbitExecutionStatus::kId, 2000, 0},
};

// The streams of one link.
class Streams {
  public:
    static constexpr uint64_t kShortest_us = 10'000;  // of an interval
    static constexpr uint64_t kNever = UINT64_MAX;

    explicit Streams() { use(Role::kGround); }
    // The usual intervals of a role, from now on.
    void use(Role role);

    // `interval_us` as in SET_MESSAGE_INTERVAL: 0 the usual one, -1 off. False: there is no such
    // stream. A heartbeat is told at least each second.
    bool set(uint32_t id, float interval_us, uint64_t now_us);
    // As in MESSAGE_INTERVAL: -1 off, 0 if the stream is unknown.
    int32_t interval_us(uint32_t id) const;
    // The stream that has been due for longest, and is due again an interval later. 0xFFFF: none.
    uint16_t take_due(uint64_t now_us);
    // Whether this one is due; then it is due again an interval later.
    bool take(uint32_t id, uint64_t now_us);
    // Due at once, besides its interval.
    void hasten(uint32_t id, uint64_t now_us);

  private:
    struct State {
        uint64_t due_us = 0;
        uint32_t interval_us = 0;  // 0: off
    };
    static void put_off(State& state, uint64_t now_us);
    static uint32_t usual_us(const Stream& stream, Role role);

    Role role_ = Role::kGround;
    std::array<State, kStreams.size()> states_{};
};

inline constexpr uint16_t kNoStream = 0xFFFF;

}  // namespace stator::apps::mavlink
