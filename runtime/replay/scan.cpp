// Reads the streams of a recording: where each activation begins, and room for every sample that
// was published.
#include <cstring>
#include <string_view>

#include "run.hpp"
#include "stator/sample_hash.hpp"

namespace stator::replay {

namespace {

template <class Row>
const Row* find(const Row* rows, size_t count, std::string_view name) {
    for (size_t i = 0; i < count; ++i) {
        if (name == rows[i].name) return rows + i;
    }
    return nullptr;
}

}  // namespace

Replay::Replay(const Recording& recording)
    : recording_(recording),
      stores_(recording.topics.size()),
      tasks_(recording.tasks.size()),
      results_(recording.topics.size()) {
    for (size_t i = 0; i < stores_.size(); ++i) {
        stores_[i].row = find(program.topics, program.topic_count, recording.topics[i].name);
    }
    for (size_t i = 0; i < tasks_.size(); ++i) {
        const Task* row = find(program.tasks, program.task_count, recording.tasks[i].name);
        if (row != nullptr) tasks_[i].run = row->run;
        tasks_[i].numbers.assign(recording.tasks[i].ports.size(), 0);
    }
    for (Level& level : levels_) level.seen.assign(tasks_.size(), 0);
}

bool Replay::scan() {
    for (unsigned level = 0; level < kStreams; ++level) {
        if (!scan_level(level)) return false;
    }
    for (TaskState& task : tasks_) {
        task.numbers.assign(task.numbers.size(), 0);
        task.now_us = 0;
    }
    return true;
}

// The last record may be cut.
bool Replay::scan_level(unsigned level) {
    const auto& stream = recording_.streams[level];
    for (size_t at = 0; at < stream.size();) {
        Reader reader(stream, at);
        Job job;
        if (!read(reader, job, true)) return reader.is_past_end();
        tasks_[job.task_].activations.push_back({job.now_us_, at});
        levels_[level].tasks.push_back(static_cast<uint32_t>(job.task_));
        at = reader.at();
    }
    return true;
}

// One record. False if it is cut or makes no sense. In a scan, what it published gets its place.
bool Replay::read(Reader& reader, Job& job, bool is_scan) {
    job.replay_ = this;
    job.task_ = reader.number();
    if (reader.is_past_end() || job.task_ >= tasks_.size()) return false;
    TaskState& task = tasks_[job.task_];
    const std::vector<Port>& ports = recording_.tasks[job.task_].ports;
    std::vector<uint32_t> numbers = task.numbers;
    std::vector<const uint8_t*> samples;
    for (uint64_t tag = reader.number(); tag != 0; tag = reader.number()) {
        if (tag > ports.size()) return false;
        const Port& port = ports[tag - 1];
        Job::Item item{static_cast<uint8_t>(tag), false, 0, 0};
        const uint8_t* whole = nullptr;
        if (!port.is_input && port.is_whole) {
            const size_t bytes = recording_.topics[port.topic].bytes;
            whole = reader.skip(bytes);
            if (whole != nullptr) item.hash = sample_hash(whole, bytes);
        } else if (!port.is_input && !port.is_stamp) {
            item.hash = reader.word();
        }
        numbers[tag - 1] += static_cast<uint32_t>(reader.number());
        item.number = numbers[tag - 1];
        job.items_.push_back(item);
        samples.push_back(whole);
    }
    job.fired_ = reader.number();
    job.now_us_ = task.now_us + reader.number();
    if (recording_.has_modes) reader.number();
    for (size_t i = 0; job.is_anew() && i < ports.size(); ++i) {
        if (ports[i].is_cursor) job.starts_.push_back(static_cast<uint32_t>(reader.number()));
    }
    if (reader.is_past_end()) return false;
    task.numbers = numbers;
    task.now_us = job.now_us_;
    for (size_t i = 0; is_scan && i < job.items_.size(); ++i) {
        keep(job, job.items_[i], samples[i]);
    }
    return true;
}

void Replay::keep(const Job& job, const Job::Item& item, const uint8_t* whole) {
    const Port& port = recording_.tasks[job.task_].ports[item.tag - 1];
    if (port.is_input) return;
    const size_t bytes = recording_.topics[port.topic].bytes;
    const uint32_t number = item.number;
    Store& store = stores_[port.topic];
    if (store.states.size() <= number) {
        store.states.resize(number + 1, State::kBeyond);
        store.producers.resize(number + 1, 0);
        store.samples.resize(bytes * (number + 1));
    }
    const bool is_made = whole != nullptr || port.is_stamp;
    store.states[number] = is_made ? State::kMade : State::kRecorded;
    store.producers[number] = static_cast<uint32_t>(job.task_);
    if (whole != nullptr) std::memcpy(slot(port.topic, number), whole, bytes);
    // A message begins with its timestamp.
    if (port.is_stamp) std::memcpy(slot(port.topic, number), &job.now_us_, sizeof job.now_us_);
}

uint8_t* Replay::slot(size_t topic, uint32_t number) {
    return stores_[topic].samples.data() + recording_.topics[topic].bytes * number;
}

}  // namespace stator::replay
