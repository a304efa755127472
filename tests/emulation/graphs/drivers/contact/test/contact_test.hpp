// A switch that tests press.
#pragma once

#include "../../../journal.hpp"
#include "contact_ports.hpp"

namespace stator::drivers::contact::test {

class ContactTest {
  public:
    struct Device {
        uint32_t activations = 0;
    };

    explicit ContactTest(Device& device) : device_(device) {}
    // Says what woke it: up, down, timer.
    void step(ContactPorts& ports) {
        ++device_.activations;
        journal::note(ports.params->id);
        if (ports.fired.up) semihosting::print("^");
        if (ports.fired.down) semihosting::print("_");
        if (ports.fired.timers != 0) semihosting::print(".");
        ports.event.publish([&] { return Event{.value = device_.activations}; });
        semihosting::print(";");
    }

  private:
    Device& device_;
};

}  // namespace stator::drivers::contact::test
