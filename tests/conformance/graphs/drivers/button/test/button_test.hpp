// A button whose presses are a node's doing, so that they come at a known place in its activation.
#pragma once

#include "../../../trace.hpp"
#include "button_ports.hpp"

namespace stator::drivers::button::test {

class ButtonTest {
  public:
    struct Device {
        void (*press)() = nullptr;  // the button that this finger pushes; none: it is a button
    };

    explicit ButtonTest(Device& device) : device_(device) {}
    // The clock at which a line was raised differs between machines: then only its step is written.
    void step(ButtonPorts& ports) {
        const int32_t id = ports.params->id;
        const uint64_t late_us = ports.fired.pressed ? ports.now % trace::kStep_us : 0;
        trace::Line begin(ports.now - late_us, " +#", id);
        begin.text(" ").number(++activations_);
        if (ports.fired.pressed) begin.text(" pressed");
        if (ports.fired.timers != 0) begin.text(" t").number(ports.fired.timers);
        begin.sample(" a=", ports.a).write();
        if (device_.press != nullptr) device_.press();
        ports.out.publish(
            [&] { return Ping{.source = static_cast<uint32_t>(id), .value = activations_}; });
        trace::Line(ports.now - late_us, " -#", id).write();
    }

  private:
    Device& device_;
    uint32_t activations_ = 0;
};

}  // namespace stator::drivers::button::test
