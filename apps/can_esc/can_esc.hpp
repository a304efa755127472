// Motor controllers on a CAN bus, in place of the motors' own outputs: ActuatorMotors becomes
// DroneCAN's esc.RawCommand, and esc.Status becomes EscStatus.
#pragma once

#include "can_esc_ports.hpp"
#include "dronecan/equipment/esc/raw_command.hpp"
#include "dronecan/equipment/esc/status.hpp"
#include "dronecan/equipment/safety/arming_status.hpp"
#include "stator/dronecan/receiver.hpp"
#include "stator/dronecan/sender.hpp"

namespace stator::apps::can_esc {

// Commands go out as they come, one an interval at most, and reports 10 times a second. Without a
// command, or with one that is too old, every motor is told to stop.
class CanEsc {
  public:
    CanEsc();
    void step(CanEscPorts& ports);

  private:
    static constexpr unsigned kMaxEscs = 12;
    using Report = dronecan::equipment::esc::Status;
    // Of one controller.
    struct Esc {
        Report report{};
        uint64_t heard_us = 0;
        uint8_t node = 0;
    };

    void configure(const CanEscParams& params);
    void receive(const CanFrame& received);
    bool is_plausible(const Report& report, uint64_t now_us) const;
    bool is_online(const Esc& esc, uint64_t now_us) const;
    bool is_due(const CanEscPorts& ports);
    void command(CanEscPorts& ports);
    void announce_arming(CanEscPorts& ports);
    EscStatus report(uint64_t now_us);
    template <class Message>
    void send(CanEscPorts& ports, const Message& message, uint8_t priority, uint8_t& transfer_id,
              uint64_t timestamp_sample);

    dronecan::Receiver<kMaxEscs, Report::kType.most_bytes> receiver_;
    std::array<Esc, kMaxEscs> escs_{};
    uint64_t offline_timeout_us_ = 0;
    uint64_t next_report_us_ = 0;
    uint64_t interval_us_ = 1;
    uint64_t next_command_us_ = 0;
    uint64_t next_stop_us_ = 0;
    unsigned count_ = 0;
    uint16_t reports_ = 0;
    uint8_t node_id_ = 0;
    uint8_t command_id_ = 0;
    uint8_t arming_id_ = 0;
};

}  // namespace stator::apps::can_esc
