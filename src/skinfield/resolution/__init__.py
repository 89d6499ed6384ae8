"""What a layout can resolve, before it is made, and what a solver makes of a point."""

from skinfield.resolution.accuracy import PlaceAccuracy as PlaceAccuracy
from skinfield.resolution.accuracy import place_accuracy as place_accuracy
from skinfield.resolution.blind import BlindSpots as BlindSpots
from skinfield.resolution.blind import Hole as Hole
from skinfield.resolution.blind import blind_spots as blind_spots
from skinfield.resolution.design import Places as Places
from skinfield.resolution.design import SkinDesign as SkinDesign
from skinfield.resolution.design import Touch as Touch
from skinfield.resolution.detectable import DetectableForce as DetectableForce
from skinfield.resolution.detectable import detectable_force as detectable_force
from skinfield.resolution.judgement import Judgement as Judgement
from skinfield.resolution.judgement import Terms as Terms
from skinfield.resolution.judgement import judge as judge
from skinfield.resolution.matrix import ResolutionMatrix as ResolutionMatrix
from skinfield.resolution.matrix import SpreadMetrics as SpreadMetrics
from skinfield.resolution.matrix import resolution_matrix as resolution_matrix
from skinfield.resolution.thickness import ThicknessComparison as ThicknessComparison
from skinfield.resolution.thickness import compare_thickness as compare_thickness
from skinfield.resolution.two_points import TwoPointDistance as TwoPointDistance
from skinfield.resolution.two_points import few_places as few_places
from skinfield.resolution.two_points import two_point_distance as two_point_distance
