// One topic and the jobs that touch it: runs the product's topic code, lets a schedule preempt it
// at every access of a shared word, and checks what each job gets.
#pragma once

#include <array>
#include <cstdint>

#include "stator/topic.hpp"
#include "topology.hpp"

namespace stator::explorer {

inline constexpr unsigned kMostSlots = 16;
inline constexpr unsigned kMostUsers = 6;
inline constexpr unsigned kMostRing = 8;

// Decides at each point who preempts the running job.
class World;
class Schedule {
  public:
    virtual ~Schedule() = default;
    // The user to activate, or `kNobody` to let the running job go on.
    virtual int choose(World& world) = 0;
    static constexpr int kNobody = -1;
};

// Both halves are written apart, with a point in between, so that a torn sample shows.
struct Sample {
    uint32_t first;
    uint32_t second;
};

// One activation. Its fields, with what it has loaded since the phase began, determine all its
// local variables.
struct Job {
    enum class Phase : uint8_t { kTaking, kHolding, kLoaning, kBuilding, kCommitting, kReleasing };

    unsigned user = 0;
    Phase phase = Phase::kTaking;
    bool only_publishes = false;
    bool has_pin = false;
    bool has_loan = false;
    bool is_built = false;  // the loan is past its commit point
    unsigned published = 0;
    Pin pin{};
    Loan loaned{};
    uint32_t newest_at_start = 0;
    bool any_at_start = false;
    unsigned accesses = 0;  // since the phase began
    unsigned load_count = 0;
    struct Load {
        uint32_t value;
        bool is_number;  // counts samples: only its distance to the newest matters
    };
    std::array<Load, 32> loads{};

    void enter(Phase next) {
        phase = next;
        accesses = 0;
        load_count = 0;
    }
};

class World {
  public:
    // `slots` may differ from what the topology needs, to see what happens. `first` is the number
    // before the first sample. `published`: so many samples are there when the schedule begins.
    World(const Topology& topology, unsigned slots, uint32_t first, unsigned published);

    // Runs one schedule from the start. False: `violation()` says what went wrong.
    bool run(Schedule& schedule);
    const char* violation() const { return violation_; }

    // --- for schedules ---
    unsigned job_count() const { return job_count_; }
    const Job& job() const { return jobs_[job_count_ - 1]; }
    bool may_run(unsigned user) const;
    // Runs one activation at once; `only_publishes`: a node need not read what it could.
    void activate(unsigned user, bool only_publishes = false);
    // Nothing more to be learnt from this run: it goes on without points and checks.
    void end_early() { is_over_ = true; }
    // A hash of everything that the rest of the run depends on.
    uint64_t state_hash() const;
    const Topology& topology() const { return topology_; }

    // --- for the executor below the topic code ---
    void pass_point();
    void note_load(const void* word, uint32_t value);
    void note_store(const void* word);
    unsigned raise_ceiling(unsigned ceiling);
    void restore_ceiling(unsigned ceiling) { ceiling_ = ceiling; }
    [[noreturn]] void fail(const char* what);

  private:
    struct Violation {};

    void publish_first();
    void step(Job& job);
    bool take(Job& job);
    void publish(Job& job);
    void check_taken(const Job& job, uint32_t cursor, uint32_t lost, uint32_t number);
    void check_loaned(const Job& job);
    void check_idle();
    void expect(bool condition, const char* what) {
        if (!condition && !is_over_) fail(what);
    }
    bool is_number(const void* word) const;
    bool is_any_in(Job::Phase phase) const;
    uint32_t newest() const;
    bool is_any() const;
    unsigned slot_of(const Pin& pin) const;

    Topology topology_;
    unsigned slots_;
    uint32_t first_;
    unsigned published_;
    Schedule* schedule_ = nullptr;
    const char* violation_ = nullptr;
    bool is_over_ = false;
    unsigned ceiling_ = 0;
    uint32_t last_newest_ = 0;
    unsigned job_count_ = 0;
    std::array<Job, kMostUsers> jobs_{};
    std::array<bool, kMostUsers> keep_{};
    std::array<bool, kMostUsers> marks_{};
    std::array<uint32_t, kMostUsers> cursor_{};
    std::array<uint32_t, kMostUsers> lost_{};
    std::array<Sample, kMostSlots> samples_{};
    std::array<Shared<uint32_t>, kMostSlots> number_{};
    std::array<Shared<uint32_t>, kMostRing> ring_{};
    TopicState state_{};
    TurnState turns_{};
    std::array<uint32_t, kMostSlots> built_{};  // where slots take turns: the number of each sample
    uint32_t stamp_ = 0;
    Topic topic_{};
};

}  // namespace stator::explorer
