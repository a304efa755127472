#include "station.hpp"

#include "journal.hpp"
#include "stator/executor.hpp"

namespace stator::apps::station {

namespace journal {
std::vector<Entry> entries;
std::string order;
unsigned torn = 0;
}  // namespace journal

namespace {

constexpr uint32_t seal_of(uint32_t value, uint32_t source) {
    return (value * 2654435761U) ^ (source << 7);
}
bool is_whole(const Ping& ping) {
    return ping.seal == seal_of(ping.value, ping.source);
}

}  // namespace

// Absent inputs are noted as such.
void Station::step(StationPorts& ports) {
    const int id = ports.params->id;
    ++activations_;
    journal::order += "+" + std::to_string(id) + " ";
    journal::Entry entry{.id = id,
                         .activation = activations_,
                         .now_us = ports.now,
                         .clock_us = executor.now_us,
                         .timers = ports.fired.timers,
                         .has_a = static_cast<bool>(ports.a),
                         .a_is_new = ports.a.is_new(),
                         .a_value = ports.a ? ports.a->value : 0,
                         .a_source = ports.a ? ports.a->source : 0,
                         .a_lost = ports.a.lost(),
                         .b_values = {},
                         .b_lost = 0};
    while (ports.b.next()) {
        entry.b_values.push_back(ports.b->value);
        journal::torn += is_whole(*ports.b) ? 0U : 1U;
    }
    entry.b_lost = ports.b.lost();
    journal::entries.push_back(entry);
    for (int i = 0; i < ports.params->count; ++i) {
        ++published_;
        const uint32_t value = published_;
        ports.out.publish([&] {
            preemption_point();
            const auto source = static_cast<uint32_t>(id);
            return Ping{.timestamp = 0,
                        .value = value,
                        .source = source,
                        .seal = seal_of(value, source),
                        ._padding0 = {}};
        });
    }
    if (ports.a && (!is_whole(*ports.a) || ports.a->value != entry.a_value)) ++journal::torn;
    journal::order += "-" + std::to_string(id) + " ";
}

}  // namespace stator::apps::station
