// What the firmware tells on its link: docs/link.md lists requests and answers.
#include "stator/link.hpp"

#include <algorithm>

#include "stator/answers.hpp"
#include "stator/cortex_m.hpp"
#include "stator/observe.hpp"
#include "stator/one_core_copy.hpp"

namespace stator {

const Transport* link_transport = nullptr;

namespace {

TaskCounters figures_below(const TaskCounters& counters) {
    return figures_below_tasks(counters, [](const uint32_t& counter) {
        return __atomic_load_n(&counter, __ATOMIC_RELAXED);
    });
}

void put_sample(Writer& out, unsigned index) {
    const Topic& topic = *program.topics[index];
    const auto bytes = std::min(topic.sample_bytes, kMaxSampleBytes);
    uint32_t number = 0;
    out.put(static_cast<uint16_t>(index));
    Writer body = out;
    body.put(number);
    if (!copy_newest_below(topic, body.at(), bytes, number)) return out.put(uint32_t{0});
    out.put(number);
    out.skip(bytes);
}

TaskCounters figures_of(unsigned task) {
    return figures_below(*program.tasks[task].counters);
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

TaskCounters figures_of(const ObservedTask& task) {
    return figures_below(*task.counters);
}

uint32_t observed_ticks_hz() {
#ifdef STATOR_COUNTERS
    return board::kTickSource.hz;
#else
    return 0;
#endif
}

bool copy_newest(const Topic& topic, uint8_t* to, size_t bytes, uint32_t& number) {
    return copy_newest_below(topic, to, bytes, number);
}

void serve_link() {
    if (link_transport != nullptr) link_of_firmware.serve(*link_transport);
}

}  // namespace stator
