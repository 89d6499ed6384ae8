"""Whether anything touches: tests of readings with a stated rate of false alarms."""

from skinfield.detection.detection import Detection as Detection
from skinfield.detection.detector import Detector as Detector
from skinfield.detection.detector import DetectorStream as DetectorStream
from skinfield.detection.statistics import LargestMatch as LargestMatch
from skinfield.detection.statistics import MarginalLikelihood as MarginalLikelihood
from skinfield.detection.statistics import Statistic as Statistic
