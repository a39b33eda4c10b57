// Counts how often each kind of input is noticed, and collects the figures behind it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/checks/thresholds.h"

namespace hexrelief::checks::mistakes {

using Findings = std::vector<Finding>;

// The counts of one kind of input.
struct Tally {
    int tried = 0, noticed = 0, otherwise = 0, silent = 0;
    std::vector<std::string> exceptions;
};

// A figure's extremes: the one of correct inputs that is nearest to wrong ones, and vice versa.
struct Extremes {
    bool large_is_right = false;
    double threshold = 0;
    double right = NAN, wrong = NAN;
};

class Table {
  public:
    // expected: the mistakes that may be found in this input; empty for correct ones.
    void add(const std::string& input, const std::string& scene, const Findings& findings,
             const std::vector<Mistake>& expected) {
        const auto known =
            std::find_if(rows_.begin(), rows_.end(), [&](const auto& r) { return r.first == input; });
        Tally& tally = known == rows_.end() ? rows_.emplace_back(input, Tally{}).second : known->second;
        ++tally.tried;
        const bool hit = std::any_of(findings.begin(), findings.end(), [&](const Finding& finding) {
            return std::find(expected.begin(), expected.end(), finding.mistake) != expected.end();
        });
        if (hit && findings.size() == 1) {
            ++tally.noticed;
            if (tally.noticed == 1) example(input, findings.front().text);
            return;
        }
        ++(findings.empty() ? tally.silent : tally.otherwise);
        if (expected.empty() && findings.empty()) return;
        tally.exceptions.push_back(scene + (findings.empty() ? " (silent)" : ""));
        for (const Finding& finding : findings) tally.exceptions.back() += "\n      " + finding.text;
    }

    void figure(const std::string& name, bool right, double value, bool large_is_right, double threshold) {
        Extremes& e = figures_[name];
        e.large_is_right = large_is_right;
        e.threshold = threshold;
        double& extreme = right ? e.right : e.wrong;
        const bool take_less = right == large_is_right;
        if (std::isnan(extreme) || (take_less ? value < extreme : value > extreme)) extreme = value;
    }

    void print() const {
        std::printf("%-46s %6s %8s %10s %7s\n", "input", "tried", "noticed", "otherwise", "silent");
        for (const auto& [name, tally] : rows_)
            std::printf("%-46s %6d %8d %10d %7d\n", name.c_str(), tally.tried, tally.noticed, tally.otherwise,
                        tally.silent);
        std::printf("\n%-46s %10s %10s %10s\n", "figure", "right", "wrong", "threshold");
        for (const auto& [name, e] : figures_)
            std::printf("%-46s %s%9.4f %s%9.4f %10.4f\n", name.c_str(), e.large_is_right ? ">" : "<", e.right,
                        e.large_is_right ? "<" : ">", e.wrong, e.threshold);
        std::printf("\nNot as expected:\n");
        for (const auto& [name, tally] : rows_)
            for (const std::string& text : tally.exceptions)
                std::printf("  %s: %s\n", name.c_str(), text.c_str());
        std::printf("\nExamples:\n");
        for (const auto& [name, text] : examples_) std::printf("  %s: %s\n", name.c_str(), text.c_str());
    }

  private:
    void example(const std::string& input, const std::string& text) { examples_.emplace_back(input, text); }

    std::vector<std::pair<std::string, Tally>> rows_;
    std::map<std::string, Extremes> figures_;
    std::vector<std::pair<std::string, std::string>> examples_;
};

}  // namespace hexrelief::checks::mistakes
