// What the firmware tells on its link: docs/link.md lists requests and answers.
#include "stator/link.hpp"

#include <algorithm>

#include "stator/cortex_m.hpp"

namespace stator {

const Transport* link_transport = nullptr;

namespace {

constexpr uint8_t kVersion = 1;
enum Request : uint8_t { kInfo = 1, kTasks = 2, kSample = 3, kFault = 4 };
constexpr unsigned kMostTasks = 20;  // in an answer
constexpr unsigned kMostTries = 4;

// Puts values one behind the other, little-endian, without padding.
class Writer {
  public:
    explicit Writer(uint8_t* at) : begin_(at), at_(at) {}
    template <class Value>
    void put(Value value) {
        put(&value, sizeof value);
    }
    void put(const void* bytes, size_t count) {
        std::memcpy(at_, bytes, count);
        at_ += count;
    }
    void text(const char* text) {
        const auto count = static_cast<uint8_t>(std::min<size_t>(std::strlen(text), 64));
        put(count);
        put(text, count);
    }
    size_t count() const { return static_cast<size_t>(at_ - begin_); }

  private:
    uint8_t* begin_;
    uint8_t* at_;
};

void put_info(Writer& out) {
    out.put(kVersion);
    out.put(static_cast<uint8_t>(is_safe_mode()));
    out.put(static_cast<uint8_t>(last_record.cause));
    out.put(board::kTickSource.unit);
    out.put(board::kTickSource.per_unit);
    out.put(board::kTickSource.hz);
    out.put(clock_us());
    out.put(static_cast<uint16_t>(program.task_count));
    out.put(static_cast<uint16_t>(program.topic_count));
    out.put(program.graph_hash, 16);
    out.text(program.graph);
    out.text(program.board);
}

uint32_t missed_life_signs_of(unsigned task) {
    for (unsigned i = 0; i < program.watched_count; ++i) {
        if (program.watched[i].task == task) return program.watched[i].state->missed;
    }
    return 0;
}

void put_tasks(Writer& out, unsigned first) {
    out.put(clock_us());
    out.put(static_cast<uint16_t>(first));
    for (unsigned i = first; i < std::min(first + kMostTasks, program.task_count); ++i) {
        // A more urgent task may change these meanwhile, the one against the other by an
        // activation.
        const TaskCounters& counters = *program.tasks[i].counters;
        out.put(counters.activations);
        out.put(counters.lost_samples);
        out.put(counters.ticks);
        out.put(counters.last_ticks);
        out.put(counters.most_ticks);
        out.put(counters.latest_us);
        out.put(missed_life_signs_of(i));
    }
}

// Without a pin, as no slot is planned for this reader: a publisher may write meanwhile, but its
// commit tells it. Gives up after some tries, as if there were no sample.
void put_sample(Writer& out, unsigned index) {
    const Topic& topic = *program.topics[index];
    out.put(static_cast<uint16_t>(index));
    for (unsigned i = 0; i < kMostTries; ++i) {
        Writer body = out;
        const uint32_t head = topic.state->head.load();
        Pin pin;
        if (head == 0 || !take_latest(topic, 0, pin, false)) break;
        const auto bytes = std::min<uint16_t>(topic.sample_bytes, 1000);
        body.put(head);
        body.put(static_cast<const uint8_t*>(topic.samples) + pin.slot * topic.sample_bytes, bytes);
        if (topic.state->head.load() != head) continue;
        out = body;
        return;
    }
    out.put(uint32_t{0});
}

size_t answer(const uint8_t* request, size_t count, uint8_t* body) {
    if (count < 4) return 0;
    const unsigned argument = request[2] | (request[3] << 8);
    Writer out(body);
    out.put(request[0]);
    out.put(request[1]);  // what the asker calls this request
    switch (request[0]) {
        case kInfo:
            put_info(out);
            return out.count();
        case kTasks:
            put_tasks(out, argument);
            return out.count();
        case kSample:
            if (argument >= program.topic_count) return 0;
            put_sample(out, argument);
            return out.count();
        case kFault:
            out.put(last_record);
            return out.count();
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
