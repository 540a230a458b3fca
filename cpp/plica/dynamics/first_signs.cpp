#include "plica/dynamics/first_signs.hpp"

#include <algorithm>

#include "plica/core/error.hpp"

namespace plica {

namespace {

struct Sign {
  std::int64_t step;
  std::string what, hint;
};

std::string folding(const FoldedTissue& folded, std::ptrdiff_t now, std::ptrdiff_t cells) {
  const bool one = folded.count == 1;
  return std::to_string(folded.count) + " of " + std::to_string(cells) + " tissue cells folded, " +
         (one ? "" : "the first ") + "cell " + std::to_string(folded.cell) + " at (" +
         number_text(folded.place[0]) + ", " + number_text(folded.place[1]) + ", " + number_text(folded.place[2]) +
         ") m; " + std::to_string(now) + " are now";
}

}  // namespace

void FirstSigns::note(std::int64_t step, const StepRecord& record, const Points& x, const Cells& cells) {
  if (!coupling && record.flow && !record.flow->converged) coupling = Unconverged{step, record.flow->residual};
  if (!contact && record.contact && !record.contact->converged)
    contact = Unconverged{step, record.contact->gap_error};
  if (folded_tissue || record.inverted_tissue == 0) return;
  const std::optional<std::ptrdiff_t> first = first_folded_cell(x, cells);
  if (!first) return;  // the count is of an earlier look, and they have opened since
  const auto cell = static_cast<std::int32_t>(*first);
  Vector3 centre = Vector3::Zero();
  for (int k = 0; k < 4; ++k) centre += x.row(cells(cell, k)).transpose() / 4;
  folded_tissue = FoldedTissue{step, record.inverted_tissue, cell, centre};
}

void FirstSigns::validate(std::int64_t last, std::ptrdiff_t cells) const {
  const auto check = [](const char* name, double value, double bound) {
    if (!(value >= 0 && value <= bound))
      throw InvalidInput("Simulation", std::string("the state's ") + name, value, "",
                         "in [0, " + number_text(bound) + "]", "It belongs to another scene.");
  };
  if (coupling)
    check("step of an unconverged coupling", static_cast<double>(coupling->step), static_cast<double>(last));
  if (contact)
    check("step of an unconverged contact", static_cast<double>(contact->step), static_cast<double>(last));
  if (!folded_tissue) return;
  check("step of folded tissue", static_cast<double>(folded_tissue->step), static_cast<double>(last));
  check("folded cell", folded_tissue->cell, static_cast<double>(cells - 1));
}

std::string FirstSigns::text(double h, std::ptrdiff_t folded_now, std::ptrdiff_t cells, bool linear) const {
  std::vector<Sign> signs;
  if (coupling)
    signs.push_back({coupling->step,
                     "air and tissue did not agree (coupling's residual " + number_text(coupling->left) +
                         " subglottal pressures)",
                     "Try a smaller step, or a larger max_sweeps."});
  if (contact)
    signs.push_back({contact->step, "contact was left with a gap error of " + number_text(contact->left) + " m",
                     "Try a smaller step; with augmented multipliers, a larger max_augmentations."});
  if (folded_tissue)
    signs.push_back({folded_tissue->step, folding(*folded_tissue, folded_now, cells),
                     std::string(linear ? "Linear tissue" : "The mesh") +
                         " cannot bear that: try less pressure, less speed or stiffer tissue."});
  std::stable_sort(signs.begin(), signs.end(), [](const Sign& a, const Sign& b) { return a.step < b.step; });
  std::string text;
  for (const Sign& sign : signs)
    text += (text.empty() ? " First sign: at t = " : ". Then, at t = ") +
            number_text(static_cast<double>(sign.step) * h) + " s " + sign.what;
  return signs.empty() ? text : text + ". " + signs.front().hint;
}

}  // namespace plica
