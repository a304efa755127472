// Asks for a restart, and counts the starts in the memory that outlives them.
#pragma once

#include "asker_ports.hpp"

namespace stator::apps::asker {

class Asker {
  public:
    void step(AskerPorts& ports) {
        ports.status.publish(
            [] { return VehicleStatus{.arming_state = VehicleStatus::ArmingState::kDisarmed}; });
        while (ports.stored.next()) starts_ = ports.stored->data[0];
        const bool is_loaded =
            ports.memory && ports.memory->state == NonvolatileStatus::State::kLoaded;
        if (!is_loaded || is_counted_) return;
        is_counted_ = true;
        ++starts_;
        ports.store.publish([&] {
            return StoredRecord{
                .key = 1, .kind = StoredRecord::Kind::kParameter, .length = 1, .data = {starts_}};
        });
        if (starts_ > ports.params->restarts) return;
        ports.restart.publish([] { return RestartRequest{.source = 127}; });
    }

  private:
    uint8_t starts_ = 0;
    bool is_counted_ = false;
};

}  // namespace stator::apps::asker
