// The jobs, and the checks of what they get.
#include "world.hpp"

#include <bit>

namespace stator::explorer {

namespace {
World* running = nullptr;  // the world that the topic code is called from
}

void pass_point() {
    running->pass_point();
}
void note_load(const void* word, uint32_t value) {
    running->note_load(word, value);
}
void note_store(const void* word, uint32_t) {
    running->note_store(word);
}
unsigned raise_ceiling(unsigned ceiling) {
    return running->raise_ceiling(ceiling);
}
void restore_ceiling(unsigned ceiling) {
    running->restore_ceiling(ceiling);
}
void fail(const char* what) {
    running->fail(what);
}

World::World(const Topology& topology, unsigned slots, uint32_t first, unsigned published)
    : topology_(topology), slots_(slots), first_(first), published_(published) {
    for (unsigned i = 0; i < topology.users.size(); ++i) {
        const TopicUser& user = topology.users[i];
        keep_[i] = topology.is_read_above(user.level);
        marks_[i] = user.role.publishes() || user.level < topology.top();
    }
    topic_ = {.state = &state_,
              .samples = samples_.data(),
              .number = number_.data(),
              .ring = ring_.data(),
              .subscribers = nullptr,
              .thinned = nullptr,
              .in_section = &kInSection,
              .sample_bytes = sizeof(Sample),
              .subscriber_count = 0,
              .thinned_count = 0,
              .slots = static_cast<uint8_t>(slots),
              .depth = static_cast<uint8_t>(topology.depth),
              .ceiling = static_cast<uint8_t>(topology.ceiling()),
              .turns = topology.takes_turns() && slots == topology.slots() ? &turns_ : nullptr};
}

bool World::run(Schedule& schedule) {
    running = this;
    schedule_ = nullptr;
    violation_ = nullptr;
    is_over_ = false;
    ceiling_ = 0;
    job_count_ = 0;
    state_ = {Shared<uint32_t>(all_slots(slots_)), {}, Shared<uint32_t>(first_)};
    turns_ = {{}, Shared<uint32_t>(first_)};
    number_.fill(Shared<uint32_t>(first_));
    ring_ = {};
    cursor_.fill(first_);
    lost_ = {};
    last_newest_ = first_;
    publish_first();
    schedule_ = &schedule;
    try {
        pass_point();
    } catch (const Violation&) {
    }
    return violation_ == nullptr;
}

void World::publish_first() {
    unsigned publisher = 0;
    while (!topology_.users[publisher].role.publishes()) ++publisher;
    for (unsigned i = 0; i < published_; ++i) activate(publisher, true);
}

void World::fail(const char* what) {
    if (violation_ == nullptr && !is_over_) violation_ = what;
    is_over_ = true;
    throw Violation();
}

bool World::may_run(unsigned user) const {
    const unsigned level = topology_.users[user].level;
    return level > ceiling_ && (job_count_ == 0 || level > topology_.users[job().user].level);
}

void World::pass_point() {
    while (!is_over_ && schedule_ != nullptr) {
        if (job_count_ == 0) check_idle();
        const int user = schedule_->choose(*this);
        if (user == Schedule::kNobody) break;
        activate(static_cast<unsigned>(user));
    }
    if (job_count_ != 0) ++jobs_[job_count_ - 1].accesses;
}

unsigned World::raise_ceiling(unsigned ceiling) {
    const unsigned outer = ceiling_;
    if (ceiling > ceiling_) ceiling_ = ceiling;
    return outer;
}

void World::activate(unsigned user, bool only_publishes) {
    const unsigned ceiling = ceiling_;
    Job& job = jobs_[job_count_];
    ++job_count_;
    job.user = user;
    job.only_publishes = only_publishes;
    job.has_pin = job.has_loan = false;
    job.published = 0;
    job.newest_at_start = newest();
    job.any_at_start = is_any();
    try {
        step(job);
    } catch (const Violation&) {
    }
    --job_count_;
    ceiling_ = ceiling;
}

void World::step(Job& job) {
    const Role role = topology_.users[job.user].role;
    const bool reads = role.reads() && !job.only_publishes;
    Sample seen{};
    if (reads && take(job)) {
        seen = samples_[slot_of(job.pin)];
        expect(seen.first == seen.second, "a reader gets a sample that is not complete");
    }
    const unsigned burst = job.only_publishes ? 1 : topology_.users[job.user].burst;
    for (job.published = 0; role.publishes() && job.published < burst; ++job.published) {
        publish(job);
    }
    if (!job.has_pin) return;
    job.enter(role.publishes() ? Job::Phase::kReleasing : Job::Phase::kHolding);
    stator::release(topic_, job.pin, marks_[job.user]);
    const Sample& now = samples_[slot_of(job.pin)];
    expect(now.first == seen.first && now.second == seen.second,
           "a sample changes while it is read");
    job.has_pin = false;
}

bool World::take(Job& job) {
    job.enter(Job::Phase::kTaking);
    uint32_t& cursor = cursor_[job.user];
    const bool is_queue = topology_.users[job.user].role.reads_queue();
    const uint32_t before = cursor;
    uint32_t lost = 0;
    const bool marks = marks_[job.user];
    if (!(is_queue ? take_next(topic_, cursor, lost, job.pin, marks)
                   : take_latest(topic_, cursor, job.pin, marks))) {
        expect(is_queue ? job.newest_at_start == before : !job.any_at_start,
               "a sample reads as absent");
        return false;
    }
    for (unsigned i = 0; i + 1 < job_count_; ++i) {
        expect(!jobs_[i].has_loan || jobs_[i].is_built || jobs_[i].loaned.slot != slot_of(job.pin),
               "a reader takes a slot that is being built");
    }
    job.has_pin = true;
    const uint32_t number = number_of(topic_, job.pin);
    expect(topic_.turns == nullptr || number == built_[slot_of(job.pin)],
           "a sample has the wrong number");
    check_taken(job, before, lost, number);
    job.enter(Job::Phase::kHolding);
    return true;
}

void World::check_taken(const Job& job, uint32_t cursor, uint32_t lost, uint32_t number) {
    expect(static_cast<int32_t>(newest() - number) >= 0, "a sample of the future");
    if (!topology_.users[job.user].role.reads_queue()) {
        expect(static_cast<int32_t>(number - job.newest_at_start) >= 0,
               "a reader gets an older sample than the newest at its start");
        return;
    }
    const uint32_t passed = number - cursor - 1;
    expect(static_cast<int32_t>(passed) >= 0, "a queue goes backwards");
    expect(cursor_[job.user] == number, "a queue reader's cursor is not its sample's number");
    expect(lost == passed, "losses are miscounted");
    expect(passed == 0 || newest() - (number - 1) >= topology_.depth,
           "a queue skips a sample that is still there");
}

void World::publish(Job& job) {
    job.enter(Job::Phase::kLoaning);
    job.loaned = loan(topic_, keep_[job.user]);
    check_loaned(job);
    job.has_loan = true;
    job.is_built = false;
    job.enter(Job::Phase::kBuilding);
    Sample& sample = samples_[job.loaned.slot];
    const uint32_t stamp = ++stamp_;
    sample.first = stamp;
    built_[job.loaned.slot] = last_newest_ + 1;
    stator::preemption_point();
    sample.second = stamp;
    job.enter(Job::Phase::kCommitting);
    commit(topic_, job.loaned, slot_at(topic_, job.loaned.slot));
    job.has_loan = false;
}

void World::check_loaned(const Job& job) {
    expect(job.loaned.slot < slots_, "topic: no free slot");
    for (unsigned i = 0; i < job_count_; ++i) {
        const Job& other = jobs_[i];
        expect(!other.has_pin || slot_of(other.pin) != job.loaned.slot,
               "a slot in use is built again");
        expect(!other.has_loan || other.is_built || other.loaned.slot != job.loaned.slot,
               "one slot is built twice");
    }
}

void World::check_idle() {
    if (topic_.turns != nullptr) {
        expect(newest() == turns_.head.peek(), "the newest sample is not the last one published");
        return;
    }
    const uint32_t head = state_.head.peek();
    const uint32_t count = head - first_;
    const unsigned kept = count < topology_.depth ? count : topology_.depth;
    expect(state_.free.peek() == all_slots(slots_), "a slot is not given back");
    expect(newest() == head, "the newest sample is not the last one published");
    uint32_t history = 0;
    for (unsigned i = 0; i < kept; ++i) {
        const unsigned index = (head - 1 - i) & (2 * topology_.depth - 1);
        const unsigned slot = topology_.depth == 1
                                  ? static_cast<unsigned>(std::countl_zero(state_.history.peek()))
                                  : static_cast<unsigned>(std::countl_zero(ring_[index].peek()));
        history |= slot_mask(slot);
        expect(number_[slot].peek() == head - i, "a sample has the wrong number");
    }
    expect(state_.history.peek() == history, "the history is not the newest samples");
}

// The number of the newest sample that readers can see.
uint32_t World::newest() const {
    if (topic_.turns != nullptr) {
        const uint32_t head = turns_.head.peek();
        const bool is_ahead =
            is_any() && topic_.slots == 2 &&
            slot_of({.slot = reinterpret_cast<uintptr_t>(turns_.newest.peek())}) != (head & 1U);
        return is_ahead ? head + 1 : head;
    }
    if (topology_.depth != 1) return state_.head.peek();
    const uint32_t history = state_.history.peek();
    return history == 0 ? first_ : number_[static_cast<unsigned>(std::countl_zero(history))].peek();
}

bool World::is_any() const {
    return topic_.turns != nullptr ? turns_.newest.peek() != nullptr : state_.history.peek() != 0;
}

unsigned World::slot_of(const Pin& pin) const {
    return static_cast<unsigned>(reinterpret_cast<const Sample*>(sample_of(topic_, pin)) -
                                 samples_.data());
}

void World::note_store(const void* word) {
    const void* commit_word =
        topology_.depth == 1 ? static_cast<const void*>(&state_.history) : &state_.head;
    if (topic_.turns != nullptr) {
        const bool is_seen = topology_.is_read_above(topology_.top());
        commit_word = is_seen ? static_cast<const void*>(&turns_.newest) : &turns_.head;
    }
    if (word != commit_word || is_over_) return;
    expect(newest() == last_newest_ + 1, "samples are not numbered one by one");
    last_newest_ = newest();
    jobs_[job_count_ - 1].is_built = true;
}

}  // namespace stator::explorer
