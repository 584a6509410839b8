# Reads every table of a BIDS data set with R alone. In: the data set's folder. Out: a line a table of motion: name, rows, mean speed;
# and how many other tables were read.

root <- commandArgs(trailingOnly = TRUE)[1]
read_tsv <- function(path, ...) {
  read.delim(path, na.strings = "n/a", check.names = FALSE, stringsAsFactors = FALSE, quote = "", ...)
}
names <- list.files(root, pattern = "\\.tsv$", recursive = TRUE)
names <- names[!grepl("^(sourcedata|derivatives)/", names)]
others <- 0
for (name in names) {
  path <- file.path(root, name)
  if (grepl("_motion\\.tsv$", name)) {
    channels <- read_tsv(sub("_motion\\.tsv$", "_channels.tsv", path))
    motion <- read_tsv(path, header = FALSE, col.names = channels$name)
    stopifnot(all(vapply(motion, is.numeric, NA)), ncol(motion) == nrow(channels), !anyNA(motion))
    cat("motion", name, nrow(motion), format(mean(motion$speed), digits = 15), "\n")
    next
  }
  others <- others + 1
  table <- read_tsv(path)
  stopifnot(nrow(table) > 0)
  if (grepl("_events\\.tsv$", name)) {
    stopifnot(is.numeric(table$onset), is.numeric(table$duration), is.character(table$trial_type))
  }
  if (grepl("_scans\\.tsv$", name)) {
    at <- as.POSIXct(table$acq_time, format = "%Y-%m-%dT%H:%M:%SZ", tz = "UTC")
    stopifnot(!anyNA(at), at < as.POSIXct("1925-01-01", tz = "UTC"), all(diff(as.numeric(at)) >= 0))
  }
}
cat("others", others, "\n")
