# Reads the data set of a study and fits mixed models: Rscript read_study.R DATASET
#
# Needs lme4; with lmerTest p values (Satterthwaite) are printed too; with arrow a recording is read tick by tick.
# Before it: codrive analyse DATASET.

arguments <- commandArgs(trailingOnly = TRUE)
if (length(arguments) != 1) stop("usage: Rscript read_study.R DATASET")
root <- arguments[1]

read_tsv <- function(path) {
  read.delim(path, na.strings = "n/a", check.names = FALSE, stringsAsFactors = FALSE, quote = "")
}
tables <- file.path(root, "derivatives", "codrive")
if (!file.exists(file.path(tables, "trials.csv"))) {
  stop(tables, ": no tables there; run: codrive analyse ", root)
}
participants <- read_tsv(file.path(root, "participants.tsv"))
trials <- read.csv(file.path(tables, "trials.csv"), na.strings = "", stringsAsFactors = FALSE)
trials <- merge(trials, participants, by.x = "participant", by.y = "participant_id")
trials <- trials[!is.na(trials$condition), ]
trials$condition <- factor(trials$condition, levels = unique(unlist(strsplit(participants$order[1], ","))))
trials$participant <- factor(trials$participant)
cat(nlevels(trials$participant), "participants,", nrow(trials), "trials\n\n")

measures <- c("mean_speed_mps", "speed_gain_mps", "time_in_range", "speed_error_mps", "reaction_s")
print(aggregate(trials[measures], by = list(condition = trials$condition), FUN = mean, na.rm = TRUE))

# One random intercept a participant; place is the order effect that the Latin square balances.
library(if (requireNamespace("lmerTest", quietly = TRUE)) "lmerTest" else "lme4", character.only = TRUE)
for (measure in measures) {
  formula <- as.formula(paste(measure, "~ condition + place + (1 | participant)"))
  model <- lmer(formula, data = trials)
  cat("\n==", measure, "==\n")
  print(summary(model)$coefficients)
  print(anova(model))
}

# Reaction times, change by change (SAE J2944): skewed, hence their logarithm.
advice <- read.csv(file.path(tables, "advice.csv"), na.strings = "", stringsAsFactors = FALSE)
advice <- advice[!is.na(advice$condition) & !is.na(advice$reaction_s), ]
if (nrow(advice) > 2 * length(unique(advice$participant))) {
  cat("\n== reaction to each change of the advice ==\n")
  print(summary(lmer(log(reaction_s) ~ condition + (1 | participant), data = advice))$coefficients)
}

if (requireNamespace("arrow", quietly = TRUE)) {
  subject <- as.character(trials$participant[1])
  scans <- read_tsv(file.path(root, subject, paste0(subject, "_scans.tsv")))
  ego <- arrow::read_parquet(file.path(root, scans$recording[nrow(scans)], "ego.parquet"))
  cat("\n", scans$recording[nrow(scans)], ": ", nrow(ego), " ticks, mean speed of all vehicles ",
      round(mean(ego$mean_speed_mps), 3), " m/s\n", sep = "")
}
