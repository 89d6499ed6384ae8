"""Touch detector: tests of readings with a stated rate of false alarms."""

from skinfield.solve.detection.detection import Detection as Detection
from skinfield.solve.detection.detector import Detector as Detector
from skinfield.solve.detection.detector import DetectorStream as DetectorStream
from skinfield.solve.detection.statistics import LargestMatch as LargestMatch
from skinfield.solve.detection.statistics import MarginalLikelihood as MarginalLikelihood
from skinfield.solve.detection.statistics import Statistic as Statistic
