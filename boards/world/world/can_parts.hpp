// What is on the simulated CAN bus beside the vehicle: a controller for each motor and a
// satellite receiver, which speak DroneCAN.
#pragma once

#include <optional>

#include "dronecan/equipment/esc/raw_command.hpp"
#include "stator/dronecan/receiver.hpp"
#include "stator/dronecan/sender.hpp"
#include "world/gnss_part.hpp"
#include "world/world.hpp"

namespace stator::world {

// Silent until the vehicle has sent something, so that graphs without CAN pay nothing for it.
class CanParts {
  public:
    using Control = Controls;

    // Where their frames go, when.
    using Send = void (*)(const dronecan::Frame& frame, std::uint64_t now_us);

    CanParts(const World& world, Send sink);

    // A frame of the vehicle. The new motor commands, if it ended a transfer of them.
    std::optional<Control> receive(const dronecan::Frame& frame, std::uint64_t now_us);
    // At each event of the world; sends what is due.
    void run(const World& world);
    // Controllers that get no commands stop. True once, when they do.
    bool times_out(std::uint64_t now_us);

  private:
    static constexpr unsigned kNodes = kMaxRotors + 1;

    template <class Message>
    void send(const Message& message, unsigned part, std::uint8_t& transfer_id,
              std::uint64_t now_us);
    void send_fix(const GnssFix& fix, std::uint64_t now_us);
    void report(const World& world, unsigned motor);

    Send send_;
    unsigned rotors_;
    GnssPart gnss_;
    dronecan::Receiver<1, dronecan::equipment::esc::RawCommand::kType.most_bytes> receiver_;
    Timer report_timer_{.period_us = 50'000};
    Timer status_timer_{.period_us = 1'000'000};
    std::array<std::uint8_t, kNodes> status_ids_{};
    std::array<std::uint8_t, kMaxRotors> report_ids_{};
    std::uint8_t fix_id_ = 0;
    std::uint8_t geometry_id_ = 0;
    std::uint64_t commanded_us_ = 0;
    Control control_{};
    bool awake_ = false;
    bool commanded_ = false;
};

}  // namespace stator::world
