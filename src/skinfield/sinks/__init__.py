"""Where results go: the edge of the package. A file has its name once it is whole."""

from skinfield.sinks.contacts import ContactWriter as ContactWriter
from skinfield.sinks.contacts import open_contacts as open_contacts
from skinfield.sinks.contacts import write_contacts as write_contacts
from skinfield.sinks.fields import FieldWriter as FieldWriter
from skinfield.sinks.fields import open_fields as open_fields
from skinfield.sinks.fields import write_fields as write_fields
from skinfield.sinks.pending import Sink as Sink
from skinfield.sinks.recordings import save_recording as save_recording
from skinfield.sinks.results import ResultsWriter as ResultsWriter
from skinfield.sinks.results import save_results as save_results
from skinfield.sinks.summary import write_summary as write_summary
