// The most slots that a topic of one core can need: a full search over what its jobs can hold. It
// knows no formula. Taking, loaning and committing are single steps here, as the plan counts what
// is held, and not the instructions in between.
//
//   stdin, one topic a line:  DEPTH USER ...   a user is its level, what it holds, what it
//   publishes:
//     n  the newest sample, from its start to its end      N  the newest one, now and then
//     o  any sample of the history, from start to end      O  any one, now and then
//     c  the newest one while it builds the next
//     p3 publishes up to three times in an activation; p0: any number of times
//   such as  2 1np2 3o 4oN     stdout: for each line the slots that are needed
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string>
#include <unordered_set>
#include <vector>

namespace {

constexpr int8_t kNone = -1;
constexpr int8_t kFresh = 100;  // named again with the state
constexpr int8_t kAnyNumber = 100;
constexpr unsigned kMaxPins = 4;

struct User {
    int level = 0;
    std::string holds;
    bool copies_newest = false;
    bool publishes = false;
    int8_t most = 0;
    bool is_outranked = false;  // by a reader
};

struct Job {
    uint8_t user = 0;
    int8_t left = 0;  // publications
    int8_t loan = kNone;
    std::array<int8_t, kMaxPins> pins{kNone, kNone, kNone, kNone};
};

// Samples have names; the same state has the same ones.
struct State {
    std::vector<int8_t> history;  // the oldest first
    std::vector<Job> jobs;        // one interrupts the other
};

class Search {
  public:
    Search(unsigned depth, std::vector<User> users) : depth_(depth), users_(std::move(users)) {}

    size_t needed() {
        add({});
        while (!todo_.empty()) {
            const State state = std::move(todo_.back());
            todo_.pop_back();
            start_jobs(state);
            if (!state.jobs.empty()) go_on(state);
        }
        return needed_;
    }

  private:
    void add(State state) {
        std::vector<int8_t> names;
        const auto rename = [&](int8_t& sample) {
            if (sample == kNone) return;
            const auto found = std::find(names.begin(), names.end(), sample);
            const auto place = found - names.begin();
            if (found == names.end()) names.push_back(sample);
            sample = static_cast<int8_t>(place);
        };
        std::string key;
        for (int8_t& sample : state.history) rename(sample);
        key.push_back(static_cast<char>(state.history.size()));
        for (Job& job : state.jobs) {
            for (int8_t& pin : job.pins) rename(pin);
            rename(job.loan);
            key.push_back(static_cast<char>(job.user));
            key.push_back(static_cast<char>(job.left));
            key.push_back(static_cast<char>(job.loan));
            key.append(job.pins.begin(), job.pins.end());
        }
        if (seen_.insert(key).second) todo_.push_back(std::move(state));
    }

    // What the pin may be of, for its letter.
    static std::vector<int8_t> samples_for(char letter, const State& state) {
        if (state.history.empty()) return {};
        if (letter == 'n' || letter == 'N') return {state.history.back()};
        return state.history;
    }

    void start_jobs(const State& state) {
        const int top = state.jobs.empty() ? -1 : users_[state.jobs.back().user].level;
        for (size_t i = 0; i < users_.size(); ++i) {
            if (users_[i].level <= top) continue;
            Job job;
            job.user = static_cast<uint8_t>(i);
            job.left = users_[i].most;
            std::vector<Job> jobs = {job};
            for (size_t k = 0; k < users_[i].holds.size(); ++k) {
                const char letter = users_[i].holds[k];
                if (std::isupper(letter) != 0) continue;
                std::vector<Job> more;
                for (const Job& one : jobs) {
                    if (letter == 'o' || state.history.empty()) more.push_back(one);  // none
                    for (const int8_t sample : samples_for(letter, state)) {
                        more.push_back(one);
                        more.back().pins[k] = sample;
                    }
                }
                jobs = more;
            }
            for (const Job& one : jobs) {
                State next = state;
                next.jobs.push_back(one);
                add(next);
            }
        }
    }

    void go_on(const State& state) {
        const Job& job = state.jobs.back();
        const User& user = users_[job.user];
        if (job.loan != kNone) return commit(state);
        State ended = state;
        ended.jobs.pop_back();
        add(ended);
        for (size_t k = 0; k < user.holds.size(); ++k) {
            const char letter = user.holds[k];
            if (std::isupper(letter) == 0) continue;
            State let_go = state;
            let_go.jobs.back().pins[k] = kNone;
            add(let_go);
            for (const int8_t sample : samples_for(letter, state)) {
                State taken = state;
                taken.jobs.back().pins[k] = sample;
                add(taken);
            }
        }
        if (user.publishes && job.left != 0) loan(state);
    }

    void loan(const State& state) {
        const User& user = users_[state.jobs.back().user];
        std::vector<int8_t> used = state.history;
        const bool drops_oldest = !user.is_outranked && used.size() == depth_;
        if (drops_oldest) used.erase(used.begin());
        if (user.copies_newest && !state.history.empty()) used.push_back(state.history.back());
        for (const Job& job : state.jobs) {
            for (const int8_t pin : job.pins) {
                if (pin != kNone) used.push_back(pin);
            }
            if (job.loan != kNone) used.push_back(job.loan);
        }
        std::sort(used.begin(), used.end());
        used.erase(std::unique(used.begin(), used.end()), used.end());
        needed_ = std::max(needed_, used.size() + 1);
        State next = state;
        next.jobs.back().loan = kFresh;
        if (user.most != kAnyNumber) --next.jobs.back().left;
        add(next);
    }

    void commit(const State& state) {
        State next = state;
        next.history.push_back(next.jobs.back().loan);
        next.jobs.back().loan = kNone;
        if (next.history.size() > depth_) next.history.erase(next.history.begin());
        add(next);
    }

    unsigned depth_;
    std::vector<User> users_;
    size_t needed_ = 0;
    std::unordered_set<std::string> seen_;
    std::vector<State> todo_;
};

User parse(const std::string& word) {
    User user;
    size_t at = 0;
    user.level = std::stoi(word, &at);
    for (; at < word.size(); ++at) {
        if (word[at] == 'c') {
            user.copies_newest = true;
        } else if (word[at] == 'p') {
            user.publishes = true;
            const int most = std::stoi(word.substr(at + 1));
            user.most = most == 0 ? kAnyNumber : static_cast<int8_t>(most);
            break;
        } else {
            user.holds.push_back(word[at]);
        }
    }
    return user;
}

}  // namespace

int main() {
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream words(line);
        unsigned depth = 0;
        words >> depth;
        std::vector<User> users;
        for (std::string word; words >> word;) users.push_back(parse(word));
        for (User& user : users) {
            user.is_outranked = std::any_of(users.begin(), users.end(), [&](const User& other) {
                return !other.holds.empty() && other.level > user.level;
            });
        }
        std::printf("%zu\n", Search(depth, users).needed());
    }
    return EXIT_SUCCESS;
}
