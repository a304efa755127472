// What the firmware tells on its link: docs/link.md lists requests and answers.
#include "stator/link.hpp"

#include <algorithm>

#include "stator/answers.hpp"
#include "stator/cortex_m.hpp"

namespace stator {

const Transport* link_transport = nullptr;

namespace {

constexpr unsigned kMaxTries = 4;

// Without a pin, as no slot is planned for this reader: a publisher may write meanwhile, but its
// commit tells it. Gives up after some tries, as if there were no sample.
void put_sample(Writer& out, unsigned index) {
    const Topic& topic = *program.topics[index];
    out.put(static_cast<uint16_t>(index));
    for (unsigned i = 0; i < kMaxTries; ++i) {
        Writer body = out;
        const uint32_t head = head_of(topic).load();
        Pin pin;
        if (!take_latest(topic, 0, pin, false)) break;
        const auto bytes = std::min(topic.sample_bytes, kMaxSampleBytes);
        body.put(head);
        body.put(sample_of(topic, pin), bytes);
        if (head_of(topic).load() != head) continue;
        out = body;
        return;
    }
    out.put(uint32_t{0});
}

TaskCounters figures_of(unsigned task) {
    return figures_below_tasks(*program.tasks[task].counters, [](const uint32_t& counter) {
        return __atomic_load_n(&counter, __ATOMIC_RELAXED);
    });
}

size_t answer(const uint8_t* request, size_t count, uint8_t* body) {
    Writer out(body);
    Asked asked;
    if (!begin_answer(request, count, out, asked)) return 0;
    switch (asked.kind) {
        case Request::kInfo:
            put_info(out, program, board::kTickSource, clock_us(), is_safe_mode(),
                     static_cast<uint8_t>(last_fault_record.cause));
            return out.count();
        case Request::kTasks:
            put_tasks(out, program, clock_us(), asked.argument, figures_of);
            return out.count();
        case Request::kSample:
            if (asked.argument >= program.topic_count) return 0;
            put_sample(out, asked.argument);
            return out.count();
        case Request::kFault:
            out.put(last_fault_record);
            return out.count();
        case Request::kParameter:
            return put_parameter(out, parameter_box, request, count) ? out.count() : 0;
        default:
            return 0;
    }
}

Link link_of_firmware(answer);

}  // namespace

void serve_link() {
    if (link_transport != nullptr) link_of_firmware.serve(*link_transport);
}

}  // namespace stator
