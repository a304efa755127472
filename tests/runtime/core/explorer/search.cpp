// Breadth-first search over schedules by running each from the start. A run follows its prefix,
// then lets jobs go on until it meets a known state; at each new one it notes the activations to
// try next.
#include "search.hpp"

#include <sstream>

#include "known_states.hpp"
#include "world.hpp"

namespace stator::explorer {

namespace {

// A prefix: its parent's, then `user` activated at point number `point`.
struct Prefix {
    uint32_t parent;
    uint16_t point;
    uint8_t user;
    uint8_t activations;
};

class Search : public Schedule {
  public:
    explicit Search(const Limits& limits) : limits_(limits) { prefixes_.push_back({}); }

    Verdict search(World& world);
    int choose(World& world) override;

  private:
    void follow(uint32_t prefix);
    std::string describe(const World& world) const;

    Limits limits_;
    std::vector<Prefix> prefixes_;  // in order of activations
    std::vector<Prefix> followed_;  // the one of this run, last activation first
    KnownStates known_;
    uint32_t current_ = 0;
    unsigned point_ = 0;
};

Verdict Search::search(World& world) {
    Verdict verdict;
    verdict.is_complete = true;
    for (; current_ < prefixes_.size(); ++current_) {
        if (prefixes_[current_].activations > limits_.activations ||
            known_.size() > limits_.states) {
            verdict.is_complete = false;
            break;
        }
        verdict.activations = prefixes_[current_].activations;
        follow(current_);
        ++verdict.runs;
        if (world.run(*this)) continue;
        verdict.violation = world.violation();
        verdict.schedule = describe(world);
        break;
    }
    if (!verdict.is_complete && known_.size() > limits_.states) --verdict.activations;
    verdict.states = known_.size();
    return verdict;
}

void Search::follow(uint32_t prefix) {
    point_ = 0;
    followed_.clear();
    for (uint32_t at = prefix; at != 0; at = prefixes_[at].parent)
        followed_.push_back(prefixes_[at]);
}

int Search::choose(World& world) {
    const unsigned point = point_;
    ++point_;
    if (!followed_.empty()) {
        if (followed_.back().point != point) return kNobody;
        const int user = followed_.back().user;
        followed_.pop_back();
        return user;
    }
    // The last user has the highest level: where it may not run, nobody may.
    const auto users = static_cast<unsigned>(world.topology().users.size());
    if (!world.may_run(users - 1)) return kNobody;
    if (!known_.insert(world.state_hash())) {
        world.end_early();
        return kNobody;
    }
    const auto activations = static_cast<uint8_t>(prefixes_[current_].activations + 1);
    for (unsigned user = 0; user < users; ++user) {
        if (!world.may_run(user)) continue;
        prefixes_.push_back(
            {current_, static_cast<uint16_t>(point), static_cast<uint8_t>(user), activations});
    }
    return kNobody;
}

std::string Search::describe(const World& world) const {
    std::vector<Prefix> path;
    for (uint32_t at = current_; at != 0; at = prefixes_[at].parent) path.push_back(prefixes_[at]);
    std::ostringstream text;
    for (auto step = path.rbegin(); step != path.rend(); ++step) {
        const TopicUser& user = world.topology().users[step->user];
        text << user.level << user.role.letter << " at point " << step->point << "; ";
    }
    return text.str();
}

// Who is to be in the middle of an activation, from the bottom up.
class Constructed : public Schedule {
  public:
    explicit Constructed(const Topology& topology);
    int choose(World& world) override;

  private:
    void publish_history(World& world) const;

    std::vector<unsigned> holders_;
    unsigned publisher_ = 0;
    unsigned depth_;
    unsigned next_ = 0;  // of holders_
};

Constructed::Constructed(const Topology& topology) : depth_(topology.depth) {
    const unsigned top = topology.top();
    for (unsigned level = 1; level <= top; ++level) {
        int most = -1;
        unsigned most_holds = 0;  // and, of several, how old they can become
        for (unsigned i = 0; i < topology.users.size(); ++i) {
            const auto& [user_level, role, burst] = topology.users[i];
            if (user_level != level || (level == top && !role.publishes())) continue;
            const unsigned age = (role.reads_queue() ? depth_ : 1U) + burst;
            const unsigned holds = role.reads() && role.publishes() ? 16U + age : 1U;
            if (holds <= most_holds) continue;
            most = static_cast<int>(i);
            most_holds = holds;
        }
        if (most >= 0 && level == top) publisher_ = static_cast<unsigned>(most);
        if (most >= 0 && level < top) holders_.push_back(static_cast<unsigned>(most));
    }
}

void Constructed::publish_history(World& world) const {
    for (unsigned i = 0; i < depth_; ++i) world.activate(publisher_, true);
}

int Constructed::choose(World& world) {
    // Jobs above the last holder, and holders before they hold all they can, are left alone.
    if (next_ > holders_.size() || world.job_count() != next_) return kNobody;
    if (next_ != 0) {
        const bool publishes = world.topology().users[holders_[next_ - 1]].role.publishes();
        const Job::Phase phase = publishes ? Job::Phase::kBuilding : Job::Phase::kHolding;
        if (world.job().user != holders_[next_ - 1] || world.job().phase != phase) return kNobody;
    }
    const unsigned holder = next_;
    next_ = static_cast<unsigned>(holders_.size()) + 1;  // none of this for what runs next
    publish_history(world);
    next_ = holder + 1;
    if (holder < holders_.size()) return static_cast<int>(holders_[holder]);
    return static_cast<int>(publisher_);
}

}  // namespace

Verdict explore(const Topology& topology, unsigned slots, const Limits& limits,
                const Start& start) {
    World world(topology, slots, start.first, start.published);
    return Search(limits).search(world);
}

Verdict run_constructed(const Topology& topology, unsigned slots) {
    World world(topology, slots, 0, 0);
    Constructed schedule(topology);
    Verdict verdict;
    if (!world.run(schedule)) verdict.violation = world.violation();
    return verdict;
}

}  // namespace stator::explorer
