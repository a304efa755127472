// A node that says everything it sees.
#pragma once

#include "../../trace.hpp"
#include "station_ports.hpp"

namespace stator::apps::station {

class Station {
  public:
    // Absent inputs are left out of the trace.
    void step(StationPorts& ports) {
        const int32_t id = ports.params->id;
        trace::Line begin(ports.now, " +#", id);
        begin.text(" ").number(++activations_);
        begin.sample(" a=", ports.a).sample(" c=", ports.c).queue(" b=", ports.b);
        begin.write();
        for (int32_t i = 0; i < ports.params->count; ++i) publish(ports.out, id);
        publish(ports.more, id);
        trace::Line(ports.now, " -#", id).write();
    }

  private:
    void publish(Output<Ping>& output, int32_t id) {
        if (!output.is_connected()) return;
        const uint32_t value = ++published_;
        output.publish([&] { return Ping{.source = static_cast<uint32_t>(id), .value = value}; });
    }

    uint32_t activations_ = 0;
    uint32_t published_ = 0;
};

}  // namespace stator::apps::station
